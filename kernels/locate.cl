// Where the border lies beside each edge pixel: sets KernelEdge::offset_256.
//
// A work-item takes edges in turns. It reads the light along the edge's line (line.cl) once and looks at it through
// two windows, a wide one for where the border may be and a narrow one around where it was found:
//
//   k =  -12 ... -9 -8 ... -5 -4 -3 -2 -1  0  1  2  3 ... 8
//                    b  b  b  o  o  o  o  o  i  i  i            wide: background b, window o and i
//                 b  b  b  b  o  o  m  i  i                     narrow, middle m
//
// (for a line along the gradient; others are up to sqrt(2) longer). host/src/locate.cpp says why.
// Border rule: that of line.cl.

#define CYL_OUTWARD (4 * CYL_UNIT)    // from the edge pixel: all background from here outward
#define CYL_BLUR (2 * CYL_UNIT)       // from the border: hardly any mixed light farther away
#define CYL_REACH (5 * CYL_UNIT / 2)  // from the edge pixel: no border is looked for farther away
#define CYL_BACKGROUND_PIXELS 4
#define CYL_NOT_FOUND INT_MIN

// The pixel farthest from the edge pixel in a window, and room for the pixels of a profile: those up to the farthest
// on both sides, the background, and what a vector of a window reads beyond.
#define CYL_FARTHEST 9
#define CYL_PROFILE (2 * CYL_FARTHEST + CYL_BACKGROUND_PIXELS + 1 + 16)

// A colour or a direction in the space of colours. Light is at most 65535 a pixel, so its components and those of w
// below fit 32 bits; products take 64.
typedef struct {
  int r;
  int g;
  int b;
} Light;

typedef struct {
  int outermost;  // k of the first pixel
  int r[CYL_PROFILE];
  int g[CYL_PROFILE];
  int b[CYL_PROFILE];
} Profile;

static long dot_light(Light a, Light b) {
  return (long)a.r * b.r + (long)a.g * b.g + (long)a.b * b.b;
}

static Light light_at(const Profile* profile, int k) {
  const int i = k - profile->outermost;
  const Light light = {profile->r[i], profile->g[i], profile->b[i]};
  return light;
}

static void read_profile(Profile* profile, const Line* line, const global ushort* light) {
  // How far a window around a border that is just in reach goes.
  const int recentred = pixels_along(line, CYL_REACH) + 1 + pixels_along(line, CYL_BLUR);
  profile->outermost = -max(pixels_along(line, CYL_OUTWARD), recentred) - CYL_BACKGROUND_PIXELS;
  const int count = max(pixels_along(line, CYL_INWARD), recentred) - profile->outermost + 1;
  for (int i = 0; i < count; ++i) {
    const global uchar* pixel = pixel_of_line(line, profile->outermost + i);
    profile->r[i] = light[red_of(pixel)];
    profile->g[i] = light[green_of(pixel)];
    profile->b[i] = light[blue_of(pixel)];
  }
  vstore16((int16)0, 0, profile->r + count);
  vstore16((int16)0, 0, profile->g + count);
  vstore16((int16)0, 0, profile->b + count);
}

// The part's colour direction, largest component CYL_UNIT; all zero where no pixel shows it.
static Light color_of_part(const global ColorSum* sum) {
  const ulong r = ((ulong)sum->high[0] << 32) | sum->low[0];
  const ulong g = ((ulong)sum->high[1] << 32) | sum->low[1];
  const ulong b = ((ulong)sum->high[2] << 32) | sum->low[2];
  const long largest = (long)max(max(r, g), b);
  Light color = {0, 0, 0};
  if (largest == 0) return color;
  color.r = (int)rounded_quotient((long)r * CYL_UNIT, largest);
  color.g = (int)rounded_quotient((long)g * CYL_UNIT, largest);
  color.b = (int)rounded_quotient((long)b * CYL_UNIT, largest);
  return color;
}

// The colour direction with what follows from it alone.
typedef struct {
  Light direction;
  long squared;
  ulong divisor;     // squared * CYL_BACKGROUND_PIXELS
  ulong reciprocal;  // floor((2^64 - 1) / divisor)
} PartColor;

static PartColor part_color_of(const global ColorSum* sum) {
  PartColor color;
  color.direction = color_of_part(sum);
  color.squared = dot_light(color.direction, color.direction);
  color.divisor = max((ulong)color.squared * CYL_BACKGROUND_PIXELS, 1UL);
  color.reciprocal = ~0UL / color.divisor;
  return color;
}

// A component of the outside's colour without its share along the part's, in 1/64 of a unit of light; rounded as by
// rounded_quotient. The product with the reciprocal is the quotient or one less: numerators are below 2^52.
static int orthogonal(int of_outside, int of_color, long along, const PartColor* color) {
  const long numerator = (of_outside * color->squared - along * of_color) * 64;
  const ulong magnitude = (ulong)(numerator >= 0 ? numerator : -numerator) + color->divisor / 2;
  ulong quotient = mul_hi(magnitude, color->reciprocal);
  if (magnitude - quotient * color->divisor >= color->divisor) ++quotient;
  return numerator >= 0 ? (int)quotient : -(int)quotient;
}

// Sum over eight pixels from index i on, of which the first `count` are in the window.
static long clamped_sum(const Profile* profile, int i, int count, Light w, long lowest, long highest) {
  const long8 r = convert_long8(vload8(0, profile->r + i));
  const long8 g = convert_long8(vload8(0, profile->g + i));
  const long8 b = convert_long8(vload8(0, profile->b + i));
  const long8 shares = r * (long8)w.r + g * (long8)w.g + b * (long8)w.b;
  const long8 in_window = (long8)(0, 1, 2, 3, 4, 5, 6, 7) < (long8)count;
  const long8 clamped = min(max(shares, (long8)lowest), (long8)highest) & in_window;
  const long4 four = clamped.lo + clamped.hi;
  const long2 two = four.lo + four.hi;
  return two.x + two.y;
}

// Where the outside ends on the line, in 1/CYL_SUBPIXEL from the edge pixel inward, judged from `outward` pixels
// before and `inward` behind the pixel `middle`.
static int crossing_by_share(const Profile* profile, const PartColor* color, int middle, int outward, int inward) {
  const int first = middle - outward;
  Light outside = {0, 0, 0};
  for (int k = first - CYL_BACKGROUND_PIXELS; k < first; ++k) {
    const Light pixel = light_at(profile, k);
    outside.r += pixel.r;
    outside.g += pixel.g;
    outside.b += pixel.b;
  }
  const Light direction = color->direction;
  const long along = dot_light(outside, direction);
  Light w;
  w.r = orthogonal(outside.r, direction.r, along, color);
  w.g = orthogonal(outside.g, direction.g, along, color);
  w.b = orthogonal(outside.b, direction.b, along, color);
  const long least_contrast = 300 * 64;
  if (dot_light(w, w) < least_contrast * least_contrast) return CYL_NOT_FOUND;

  const long full = dot_light(w, outside) / CYL_BACKGROUND_PIXELS;
  const int count = outward + inward + 1;
  const int i = first - profile->outermost;
  long sum = clamped_sum(profile, i, count, w, -full / 2, full + full / 2);
  if (count > 8) sum += clamped_sum(profile, i + 8, count - 8, w, -full / 2, full + full / 2);
  return first * CYL_SUBPIXEL - CYL_SUBPIXEL / 2 + (int)rounded_quotient(sum * CYL_SUBPIXEL, full);
}

// A place on the line as an offset along the gradient; CYL_NOT_FOUND out of reach.
static int offset_of(const Line* line, int crossing) {
  const int offset = (int)rounded_quotient((long)crossing * line->cosine, CYL_UNIT);
  const int reach = CYL_REACH / (CYL_UNIT / CYL_SUBPIXEL);
  return offset < -reach || offset > reach ? CYL_NOT_FOUND : offset;
}

static int offset_by_share(const Profile* profile, const Line* line, const PartColor* color) {
  const int coarse = crossing_by_share(profile, color, 0, pixels_along(line, CYL_OUTWARD),
                                       pixels_along(line, CYL_INWARD));
  if (coarse == CYL_NOT_FOUND || offset_of(line, coarse) == CYL_NOT_FOUND) return CYL_NOT_FOUND;
  const int middle = (int)rounded_quotient(coarse, CYL_SUBPIXEL);
  const int half_width = pixels_along(line, CYL_BLUR);
  const int fine = crossing_by_share(profile, color, middle, half_width, half_width);
  return fine == CYL_NOT_FOUND ? CYL_NOT_FOUND : offset_of(line, fine);
}

// Between pixels k - 1 and k.
static long slope_at(const Profile* profile, Light direction, int k) {
  return dot_light(light_at(profile, k), direction) - dot_light(light_at(profile, k - 1), direction);
}

static int offset_by_slope(const Profile* profile, const Line* line, Light direction) {
  const int innermost = pixels_along(line, CYL_INWARD) - 1;
  int best = -innermost;
  long peak = slope_at(profile, direction, best);
  for (int k = best + 1; k <= innermost; ++k) {
    const long slope = slope_at(profile, direction, k);
    if (slope > peak) {
      peak = slope;
      best = k;
    }
  }
  const long before = slope_at(profile, direction, best - 1);
  const long after = slope_at(profile, direction, best + 1);
  const long curvature = 2 * peak - before - after;
  if (peak <= 0 || before > peak || after > peak || curvature == 0) return 0;
  const int vertex = (int)rounded_quotient((after - before) * (CYL_SUBPIXEL / 2), curvature);
  const int offset = offset_of(line, best * CYL_SUBPIXEL - CYL_SUBPIXEL / 2 + vertex);
  return offset == CYL_NOT_FOUND ? 0 : offset;
}

CYL_KERNEL void locate_edges(const global uchar* image, const KernelFrame frame, const global ushort* light_tables,
                             global uchar* result) {
  const global ushort* light = light_tables + frame.light_table;
  const uint count = min(header_of(result)->edges, frame.edge_capacity);
  global KernelEdge* edges = edges_of(result, &frame);
  int part = -1;
  PartColor color;
  for (uint i = (uint)get_global_id(0); i < count; i += (uint)get_global_size(0)) {
    const KernelEdge edge = edges[i];
    if (part != edge.kind / 4) {
      part = edge.kind / 4;
      color = part_color_of(color_sums_of(result) + part);
    }
    const Line line = line_through(image, &frame, edge.x - frame.origin_x, edge.y - frame.origin_y, edge.gx, edge.gy,
                                   edge.offset_256);
    Profile profile;
    read_profile(&profile, &line, light);
    const bool has_color = color.squared != 0;
    const Light white = {CYL_UNIT, CYL_UNIT, CYL_UNIT};
    int offset = has_color ? offset_by_share(&profile, &line, &color) : CYL_NOT_FOUND;
    if (offset == CYL_NOT_FOUND) offset = offset_by_slope(&profile, &line, has_color ? color.direction : white);
    edges[i].offset_256 = (short)offset;
  }
  if (get_global_id(0) == 0) header_of(result)->stamp = frame.stamp;
}
