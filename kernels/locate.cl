// Where the border lies beside each edge pixel: sets KernelEdge::offset_256, and in KernelEdge::kind what told it.
//
// A work-item takes edges in turns. It reads the light along the edge's line (line.cl) and the line on either side, as
// far as it needs, and looks for the place where a filter of eight weights sums up to zero:
//
//   k =  -11 ... -8 -7 -6 -5 -4 -3 -2 -1  0  1  2  3  4  5 ... 13     pixels of the line
//                 b  b  b  b                                        background (for a line along the gradient)
//                             -  -  +  +  +  +  -  -                share filter, in the channel that the part has not
//                                   +  -  -  +  +  +  -  -          limb filter, in one that the outside has not
//
// host/src/locate.cpp says why. Border rule: that of line.cl.

#define CYL_OUTWARD (4 * CYL_UNIT)    // from the edge pixel: hardly any of the part's light from here outward
#define CYL_REACH (7 * CYL_UNIT / 2)  // from the edge pixel: no border is looked for farther away
#define CYL_BACKGROUND_PIXELS 4       // beyond CYL_OUTWARD, for the background's colour
#define CYL_NEAREST 2                 // pixels from the border between which the background is judged
#define CYL_FARTHEST 6
#define CYL_ROOT_BITS 8  // by which light is shifted before its root is taken
#define CYL_NOT_FOUND INT_MIN
#define CYL_BY_NOTHING 0  // EdgeCue
#define CYL_BY_SHARE 1
#define CYL_BY_LIMB 2
#define CYL_BY_SLOPE 3
#define CYL_BY_CLIPPED 4
#define CYL_CLIPPED (CYL_BACKGROUND_PIXELS * 65535 * 99 / 100)  // light of the background that the sensor cuts off

// As far as anything looks along a diagonal.
#define CYL_FIRST (-11)
#define CYL_LAST 13

// Light, at most 65535 a pixel; or a channel, a direction in the space of colours with components of at most 13 bits
// and a sign. A product of the two, summed over the colours, fits 32 bits.
typedef struct {
  int r;
  int g;
  int b;
} Light;

typedef struct {
  long r;
  long g;
  long b;
} WideLight;

// The light along a line; it counts twice, and its neighbours once.
typedef struct {
  const Lines* lines;
  const global ushort* light;
  int first;  // k of the pixels read so far
  int last;
  int r[CYL_LAST - CYL_FIRST + 1];  // from pixel CYL_FIRST on
  int g[CYL_LAST - CYL_FIRST + 1];
  int b[CYL_LAST - CYL_FIRST + 1];
} Profile;

static void read_pixel(Profile* profile, int k) {
  const Lines* lines = profile->lines;
  const global ushort* light = profile->light;
  const global uchar* before = pixel_beside(lines, -1, k);
  const global uchar* middle = pixel_of_line(&lines->middle, k);
  const global uchar* after = pixel_beside(lines, 1, k);
  const int i = k - CYL_FIRST;
  profile->r[i] = (light[red_of(before)] + 2 * light[red_of(middle)] + light[red_of(after)]) / 4;
  profile->g[i] = (light[green_of(before)] + 2 * light[green_of(middle)] + light[green_of(after)]) / 4;
  profile->b[i] = (light[blue_of(before)] + 2 * light[blue_of(middle)] + light[blue_of(after)]) / 4;
}

// Reads what is missing of the pixels first to last.
static void read_up_to(Profile* profile, int first, int last) {
  while (profile->first > first) read_pixel(profile, --profile->first);
  while (profile->last < last) read_pixel(profile, ++profile->last);
}

static WideLight wide_light_at(const Profile* profile, int k) {
  const int i = k - CYL_FIRST;
  const WideLight light = {profile->r[i], profile->g[i], profile->b[i]};
  return light;
}

static long dot_wide(WideLight a, WideLight b) {
  return a.r * b.r + a.g * b.g + a.b * b.b;
}

// What is perpendicular to `other` in `light`, times the square of `other`.
static WideLight perpendicular(WideLight light, WideLight other) {
  const long squared = dot_wide(other, other);
  const long along = dot_wide(light, other);
  const WideLight rest = {light.r * squared - along * other.r, light.g * squared - along * other.g,
                          light.b * squared - along * other.b};
  return rest;
}

#define CYL_CONTRAST_CUT 16  // bits of each component, so that the square fits

// The square of what perpendicular() gives, cut.
static long contrast(WideLight rest) {
  const WideLight cut = {rest.r >> CYL_CONTRAST_CUT, rest.g >> CYL_CONTRAST_CUT, rest.b >> CYL_CONTRAST_CUT};
  return dot_wide(cut, cut);
}

// The same direction, of no negative component, with the largest one CYL_UNIT; zero as it is.
static WideLight scaled_to_unit(WideLight direction) {
  const long largest = max(max(max(direction.r, direction.g), direction.b), 1L);
  const WideLight scaled = {rounded_quotient(direction.r * CYL_UNIT, largest),
                            rounded_quotient(direction.g * CYL_UNIT, largest),
                            rounded_quotient(direction.b * CYL_UNIT, largest)};
  return scaled;
}

// The same direction as a channel.
static Light narrowed(WideLight direction) {
  const int bits = 13;
  const ulong largest = max(max(abs(direction.r), abs(direction.g)), abs(direction.b));
  const int surplus = max(64 - (int)clz(largest) - bits, 0);
  const Light channel = {(int)(direction.r >> surplus), (int)(direction.g >> surplus), (int)(direction.b >> surplus)};
  return channel;
}

// The part's colour direction, largest component CYL_UNIT; all zero where no pixel shows it.
static Light color_of_part(const global ColorSum* sum) {
  const WideLight light = {(long)(((ulong)sum->high[0] << 32) | sum->low[0]),
                           (long)(((ulong)sum->high[1] << 32) | sum->low[1]),
                           (long)(((ulong)sum->high[2] << 32) | sum->low[2])};
  const WideLight scaled = scaled_to_unit(light);
  const Light color = {(int)scaled.r, (int)scaled.g, (int)scaled.b};
  return color;
}

// The light of a pixel in a channel, so that a filter's sum fits 32 bits.
#define CYL_LEVEL_CUT 9

static int level_at(const Profile* profile, Light channel, int k) {
  const int i = k - CYL_FIRST;
  return (profile->r[i] * channel.r + profile->g[i] * channel.g + profile->b[i] * channel.b) >> CYL_LEVEL_CUT;
}

// Weights for eight pixels, the first one `first` pixels from where the filter stands. When their sum is zero there,
// the border is `border` away, in 1/CYL_SUBPIXEL.
typedef struct {
  int8 weights;
  int first;
  int border;
} BorderFilter;

static BorderFilter share_filter(void) {
  const BorderFilter filter = {(int8)(-2, -2, 1, 3, 3, 1, -2, -2), -4, -CYL_SUBPIXEL / 2};
  return filter;
}

static BorderFilter limb_filter(void) {
  const BorderFilter filter = {(int8)(131, -134, -100, 42, 112, 38, -29, -60), -2, -CYL_SUBPIXEL / 2};
  return filter;
}

static int sum_at(Profile* profile, Light channel, const BorderFilter* filter, int k) {
  const int first = k + filter->first;
  read_up_to(profile, first, first + 7);
  const int8 r = vload8(0, profile->r + first - CYL_FIRST);
  const int8 g = vload8(0, profile->g + first - CYL_FIRST);
  const int8 b = vload8(0, profile->b + first - CYL_FIRST);
  const int8 levels = (r * (int8)channel.r + g * (int8)channel.g + b * (int8)channel.b) >> (int8)CYL_LEVEL_CUT;
  const int8 weighted = levels * filter->weights;
  const int4 four = weighted.lo + weighted.hi;
  const int2 two = four.lo + four.hi;
  return two.x + two.y;
}

// Where a function with these values at -1, 0, 1 and 2 is zero between 0 and 1, in 1/CYL_SUBPIXEL: the zero of the
// chord, moved by one Newton step on the cubic through all four.
static int zero_between(long before, long here, long next, long beyond) {
  const long drop = (long)(abs(here) + abs(next));
  const long share = rounded_quotient((long)abs(here) * CYL_SUBPIXEL, drop);
  const long bend = before - here - next + beyond;
  const long twist = beyond - before + 3 * (here - next);
  const long half_pixel = CYL_SUBPIXEL / 2;
  const long excess = share * (share - CYL_SUBPIXEL) * (3 * half_pixel * bend + (share - half_pixel) * twist);
  const long farthest = CYL_SUBPIXEL / 8;
  const long step = rounded_quotient(here > 0 ? excess : -excess, 12 * half_pixel * CYL_SUBPIXEL * drop);
  return (int)(share + clamp(step, -farthest, farthest));
}

// Where the border crosses the line, in 1/CYL_SUBPIXEL from the edge pixel inward: the filter's sum goes from positive
// to negative there. Looked for from the pixel `start` on, at most `steps` pixels away.
static int crossing(Profile* profile, Light channel, const BorderFilter* filter, int start, int steps) {
  int here = sum_at(profile, channel, filter, start);
  const bool inward = here > 0;
  const int step = inward ? 1 : -1;
  for (int k = start; k != start + steps * step; k += step) {
    const int next = sum_at(profile, channel, filter, k + step);
    if ((next > 0) != inward) {
      const int before = sum_at(profile, channel, filter, k - step);
      const int beyond = sum_at(profile, channel, filter, k + 2 * step);
      const int share = zero_between(before, here, next, beyond);
      return k * CYL_SUBPIXEL + step * share + filter->border;
    }
    here = next;
  }
  return CYL_NOT_FOUND;
}

// The outside near a border: how much its levels differ, and how far it stands out from the inside. `mirrored`: with
// the levels at equal distances inside added.
typedef struct {
  int spread;
  int height;
} Outside;

static Outside outside_of(Profile* profile, Light channel, int border, bool mirrored) {
  read_up_to(profile, border - CYL_FARTHEST, border + CYL_FARTHEST);
  int lowest = INT_MAX;
  int highest = INT_MIN;
  int height = 0;
  for (int k = CYL_NEAREST; k <= CYL_FARTHEST; ++k) {
    const int inside = level_at(profile, channel, border + k);
    const int outside = level_at(profile, channel, border - k) + (mirrored ? inside : 0);
    lowest = min(lowest, outside);
    highest = max(highest, outside);
    height += mirrored ? outside : inside - outside;
  }
  const Outside result = {highest - lowest, height};
  return result;
}

// Whether the channel that tells outside from part stands a third as high on the part's side of a border, whose
// surroundings were read: something else begins there.
static bool is_thin(const Profile* profile, Light channel, int border) {
  const int inside = level_at(profile, channel, border + 3) + level_at(profile, channel, border + 4);
  const int outside = level_at(profile, channel, border - 3) + level_at(profile, channel, border - 4);
  return 3L * abs(inside) > outside;
}

// A place on the line as an offset along the gradient; CYL_NOT_FOUND out of reach.
static int offset_of(const Line* line, int crossing) {
  const int offset = (int)rounded_quotient((long)crossing * line->cosine, CYL_UNIT);
  const int reach = CYL_REACH / (CYL_UNIT / CYL_SUBPIXEL);
  return offset < -reach || offset > reach ? CYL_NOT_FOUND : offset;
}

static int three_levels(const Profile* profile, Light channel, int k) {
  return level_at(profile, channel, k) + level_at(profile, channel, k + 1) + level_at(profile, channel, k + 2);
}

// Whether the light inside of a slope goes on to rise, and does so as straight as no limb.
static bool is_ramp(Profile* profile, Light channel, int steepest) {
  read_up_to(profile, steepest - 3, steepest + 8);
  const int near_sum = three_levels(profile, channel, steepest);
  const int middle_sum = three_levels(profile, channel, steepest + 3);
  const int far_sum = three_levels(profile, channel, steepest + 6);
  const int outside_sum = 3 * level_at(profile, channel, steepest - 3);
  return 3 * (far_sum - near_sum) > near_sum - outside_sum &&
         8 * (2 * middle_sum - near_sum - far_sum) < far_sum - near_sum;
}

// The light itself or, where `root`, its root.
static int light_at(const Profile* profile, Light channel, bool root, int k) {
  const int light = level_at(profile, channel, k);
  return root ? (int)integer_root((ulong)max(light, 0) << CYL_ROOT_BITS) : light;
}

static int rise_to(const Profile* profile, Light channel, bool root, int k) {
  return light_at(profile, channel, root, k) - light_at(profile, channel, root, k - 1);
}

// The pixel at most `reach` away that rises most above the one before it.
static int steepest_of(const Profile* profile, Light channel, bool root, int reach) {
  int steepest = -reach;
  int peak = rise_to(profile, channel, root, steepest);
  for (int k = -reach + 1; k <= reach; ++k) {
    const int rise = rise_to(profile, channel, root, k);
    if (rise > peak) {
      peak = rise;
      steepest = k;
    }
  }
  return steepest;
}

// The vertex of the slope whose largest is the rise to pixel k; CYL_NOT_FOUND where that is not the largest.
static int vertex_of(const Profile* profile, Light channel, bool root, int k) {
  const int before = rise_to(profile, channel, root, k - 1);
  const int peak = rise_to(profile, channel, root, k);
  const int after = rise_to(profile, channel, root, k + 1);
  const int curvature = 2 * peak - before - after;
  if (before > peak || after > peak || curvature == 0) return CYL_NOT_FOUND;
  return k * CYL_SUBPIXEL - CYL_SUBPIXEL / 2 +
         (int)rounded_quotient((long)(after - before) * (CYL_SUBPIXEL / 2), curvature);
}

typedef struct {
  int offset;  // CYL_NOT_FOUND where there is none
  int cue;
} Place;

static Place place_by_limb(Profile* profile, Light channel) {
  const Place none = {0, CYL_BY_NOTHING};
  const Line* line = &profile->lines->middle;
  const int reach = pixels_along(line, CYL_REACH);
  read_up_to(profile, -reach - 2, reach + 1);
  const int steepest = steepest_of(profile, channel, false, reach);
  if (rise_to(profile, channel, false, steepest) <= 0) return none;
  int border = CYL_NOT_FOUND;
  if (!is_ramp(profile, channel, steepest)) {
    const BorderFilter filter = limb_filter();
    const int steps = 2;
    border = crossing(profile, channel, &filter, steepest, steps);
  }
  int cue = CYL_BY_LIMB;
  if (border == CYL_NOT_FOUND) {
    cue = CYL_BY_SLOPE;
    border = vertex_of(profile, channel, false, steepest);
    const int beginning = vertex_of(profile, channel, true, steepest_of(profile, channel, true, reach));
    const int deep = 3 * CYL_SUBPIXEL / 2;
    if (beginning != CYL_NOT_FOUND && (border == CYL_NOT_FOUND || border - beginning > deep)) border = beginning;
  }
  if (border == CYL_NOT_FOUND) return none;
  const Place place = {offset_of(line, border), cue};
  return place.offset == CYL_NOT_FOUND ? none : place;
}

static Place place_between(Profile* profile, WideLight outside, WideLight color) {
  const Place not_found = {CYL_NOT_FOUND, CYL_BY_NOTHING};
  const Line* line = &profile->lines->middle;
  const long least = 300 * CYL_BACKGROUND_PIXELS * (dot_wide(color, color) >> CYL_CONTRAST_CUT);
  const WideLight rest = perpendicular(outside, color);
  if (contrast(rest) < least * least) return not_found;

  const Light channel = narrowed(rest);
  const BorderFilter filter = share_filter();
  const int border = crossing(profile, channel, &filter, 0, pixels_along(line, CYL_REACH));
  const Place place = {border == CYL_NOT_FOUND ? CYL_NOT_FOUND : offset_of(line, border), CYL_BY_SHARE};
  if (place.offset == CYL_NOT_FOUND) return not_found;

  const int middle = (int)rounded_quotient(border, CYL_SUBPIXEL);
  const Outside share = outside_of(profile, channel, middle, true);
  const long even = 25;  // times the spread must not be above the height
  if (even * share.spread > share.height) {
    if (is_thin(profile, channel, middle)) {
      const Place not_sure = {place.offset, CYL_BY_NOTHING};
      return not_sure;
    }
    const Light turned = narrowed(perpendicular(color, outside));
    const Outside part = outside_of(profile, turned, middle, false);
    if (2L * part.spread * share.height <= (long)share.spread * part.height) return place_by_limb(profile, turned);
  }
  return place;
}

// A direction without the colours in which the outside is clipped.
static WideLight unclipped(WideLight direction, WideLight outside) {
  const WideLight rest = {outside.r > CYL_CLIPPED ? 0 : direction.r, outside.g > CYL_CLIPPED ? 0 : direction.g,
                          outside.b > CYL_CLIPPED ? 0 : direction.b};
  return rest;
}

static Place place_by_share(Profile* profile, Light part) {
  const int outermost = -pixels_along(&profile->lines->middle, CYL_OUTWARD) - CYL_BACKGROUND_PIXELS;
  WideLight outside = {0, 0, 0};
  for (int k = outermost; k < outermost + CYL_BACKGROUND_PIXELS; ++k) {
    const WideLight pixel = wide_light_at(profile, k);
    outside.r += pixel.r;
    outside.g += pixel.g;
    outside.b += pixel.b;
  }
  const WideLight color = {part.r, part.g, part.b};
  const WideLight rest = unclipped(outside, outside);
  if (rest.r == outside.r && rest.g == outside.g && rest.b == outside.b) return place_between(profile, outside, color);
  const WideLight color_there = scaled_to_unit(unclipped(color, outside));
  Place place = {CYL_NOT_FOUND, CYL_BY_NOTHING};
  if (16 * contrast(perpendicular(rest, color_there)) >= contrast(perpendicular(outside, color))) {
    place = place_between(profile, rest, color_there);
  }
  if (place.offset == CYL_NOT_FOUND) {
    place = place_between(profile, outside, color);
    place.cue = CYL_BY_CLIPPED;
  }
  return place;
}

CYL_KERNEL void locate_edges(const global uchar* image, const KernelFrame frame, const global ushort* light_tables,
                             global uchar* result) {
  const uint count = min(header_of(result)->edges, frame.edge_capacity);
  global KernelEdge* edges = edges_of(result, &frame);
  int part = -1;
  Light color;
  for (uint i = (uint)get_global_id(0); i < count; i += (uint)get_global_size(0)) {
    const KernelEdge edge = edges[i];
    if (part != edge.kind / 32) {
      part = edge.kind / 32;
      color = color_of_part(color_sums_of(result) + part);
    }
    const Lines lines = lines_through(image, &frame, edge.x - frame.origin_x, edge.y - frame.origin_y, edge.gx, edge.gy,
                                      edge.offset_256);
    Profile profile;
    profile.lines = &lines;
    profile.light = light_tables + frame.light_table;
    profile.first = -pixels_along(&lines.middle, CYL_OUTWARD) - CYL_BACKGROUND_PIXELS;
    profile.last = profile.first - 1;
    read_up_to(&profile, profile.first, CYL_FARTHEST);  // enough for most edges
    const bool has_color = (color.r | color.g | color.b) != 0;
    const Light white = {CYL_UNIT, CYL_UNIT, CYL_UNIT};
    Place place = {CYL_NOT_FOUND, CYL_BY_NOTHING};
    if (has_color) place = place_by_share(&profile, color);
    if (place.offset == CYL_NOT_FOUND) place = place_by_limb(&profile, has_color ? color : white);
    edges[i].offset_256 = (short)place.offset;
    edges[i].kind = (ushort)(edge.kind + 4 * place.cue);
  }
  if (get_global_id(0) == 0) header_of(result)->stamp = frame.stamp;
}
