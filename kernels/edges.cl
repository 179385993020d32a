// Edge pixels: local maxima of the response's gradient near the mask's border, in any order; and the sum of the part's
// light inside of the strong ones.
//
// Band: pixels within distance 2 of the mask's border, 64 at a time. Over the 5x5 square around a pixel
//   wide = OR of the mask, core = AND of the mask (pixels that do not exist left out), band = wide and not core.
//
// Where the band has pixels, a window of 16 columns and 5 rows is looked at with vectors, one row a vector:
//
//   lane     0 1 2 3  . . .  13 14 15
//            . . . . . . . . . . . . .      row y-2   response
//            . s s s s s s s s s s s .      row y-1   response, squared gradient s
//            . s x x x x x x x x x s .      row y     ..., x: up to 12 pixels that may become edges
//            . s s s s s s s s s s s .      row y+1
//            . . . . . . . . . . . . .      row y+2
//
// Border rule: beyond the rectangle the response repeats the nearest pixel, the gradient is 0.

#define CYL_INWARD (3 * CYL_UNIT)  // from an edge pixel: all part from here inward

#define CYL_WINDOW 16
#define CYL_WINDOW_MARGIN 2
#define CYL_WINDOW_PIXELS (CYL_WINDOW - 2 * CYL_WINDOW_MARGIN)

// OR and AND over the rows up to two away that exist, of one word; bits that are no pixels count as 0 and 1.
typedef struct {
  ulong wide;
  ulong core;
} Column;

static Column column_of(const global ulong* mask, const KernelFrame* frame, int row, int word) {
  Column column = {0, ~0UL};
  if (word < 0 || word >= words_in_row(frame)) return column;
  for (int y = max(row - 2, 0); y <= min(row + 2, frame->height - 1); ++y) {
    const ulong bits = mask[row_of_plane(frame, 0, y) + (size_t)word];
    column.wide |= bits;
    column.core &= bits;
  }
  column.core |= ~pixels_of_word(frame, word);
  return column;
}

// The band in the eight words from `first` on. False when it is empty there.
static bool band_of_block(ulong* band, const global ulong* mask, const KernelFrame* frame, int row, int first) {
  ulong8 wide = 0;
  ulong8 core = ~0UL;
  for (int y = max(row - 2, 0); y <= min(row + 2, frame->height - 1); ++y) {
    const ulong8 bits = vload8(0, mask + row_of_plane(frame, 0, y) + first);
    wide |= bits;
    core &= bits;
  }
  const Column before = column_of(mask, frame, row, first - 1);
  const Column after = column_of(mask, frame, row, first + 8);
  if ((before.wide | after.wide) == 0 && !any_bit(wide)) return false;

  const int8 word = first + (int8)(0, 1, 2, 3, 4, 5, 6, 7);
  const int8 pixels_left = frame->width - word * 64;
  // Vectors as limits: Oclgrind takes scalar ones for vectors.
  const ulong8 shift = convert_ulong8(clamp(pixels_left, (int8)0, (int8)63));
  const ulong8 pixels = select(((ulong8)1 << shift) - 1UL, (ulong8)~0UL, convert_long8(pixels_left >= 64));
  core |= ~pixels;
  const ulong8 wide_before = (ulong8)(before.wide, wide.s0123, wide.s45, wide.s6);
  const ulong8 wide_after = (ulong8)(wide.s1234, wide.s56, wide.s7, after.wide);
  const ulong8 core_before = (ulong8)(before.core, core.s0123, core.s45, core.s6);
  const ulong8 core_after = (ulong8)(core.s1234, core.s56, core.s7, after.core);
  const ulong8 reached = wide | (wide << 1UL) | (wide << 2UL) | (wide >> 1UL) | (wide >> 2UL) | (wide_before >> 63UL) |
                         (wide_before >> 62UL) | (wide_after << 63UL) | (wide_after << 62UL);
  const ulong8 inner = core & ((core << 1UL) | (core_before >> 63UL)) & ((core << 2UL) | (core_before >> 62UL)) &
                       ((core >> 1UL) | (core_after << 63UL)) & ((core >> 2UL) | (core_after << 62UL));
  const ulong8 result = reached & ~inner & pixels;
  vstore8(result, 0, band);
  return any_bit(result);
}

// The response of sixteen pixels, 0..255.
CYL_INLINE short16 response_of(const KernelGate* gate, Colors colors) {
#if CYL_CHANNELS == 1
  return convert_short16(colors.red);
#else
  if (gate->any_hue != 0) {
    const uchar16 high = max(max(colors.red, colors.green), colors.blue);
    const uchar16 low = min(min(colors.red, colors.green), colors.blue);
    return convert_short16(gate->saturation_256 != 0 ? high - low : high);
  }
  const short16 rg = convert_short16(colors.red) - convert_short16(colors.green);
  const short16 bg = convert_short16(colors.blue) - convert_short16(colors.green);
  // At most 70 * 255 and 128 * 255 on either side of zero.
  const short16 along = (short)gate->response_r * rg + (short)gate->response_b * bg;
  const short16 aside = (short)gate->aside_r * rg + (short)gate->aside_b * bg;
  const short16 rest = max(along, (short16)0) - max(aside, -aside);
  return min(max(rest, (short16)0) >> (short)6, (short16)255);
#endif
}

typedef struct {
  short16 x;
  short16 y;
} Gradients;

// Sobel; lanes 0 and 15 lack a neighbour and are not used.
CYL_INLINE Gradients gradients_of(short16 above, short16 here, short16 below) {
  const short16 smooth = above + here + here + below;
  const short16 slope = below - above;
  Gradients gradients;
  gradients.x = smooth.s123456789abcdeff - smooth.s00123456789abcde;
  gradients.y = slope.s00123456789abcde + slope + slope + slope.s123456789abcdeff;
  return gradients;
}

CYL_INLINE int16 squared(Gradients gradients) {
  const int16 x = convert_int16(gradients.x);
  const int16 y = convert_int16(gradients.y);
  return x * x + y * y;
}

typedef struct {
  short gx[CYL_WINDOW];
  short gy[CYL_WINDOW];
  int squares[3 * CYL_WINDOW];
} Window;

static void fill_window(Window* window, const global uchar* image, const KernelFrame* frame, const KernelGate* gate,
                        int x, int row) {
  const int last = frame->height - 1;
  const short16 r0 = response_of(gate, colors_at(image_row(image, frame, clamp(row - 2, 0, last)), x, frame->width));
  const short16 r1 = response_of(gate, colors_at(image_row(image, frame, clamp(row - 1, 0, last)), x, frame->width));
  const short16 r2 = response_of(gate, colors_at(image_row(image, frame, row), x, frame->width));
  const short16 r3 = response_of(gate, colors_at(image_row(image, frame, clamp(row + 1, 0, last)), x, frame->width));
  const short16 r4 = response_of(gate, colors_at(image_row(image, frame, clamp(row + 2, 0, last)), x, frame->width));
  const Gradients middle = gradients_of(r1, r2, r3);
  vstore16(middle.x, 0, window->gx);
  vstore16(middle.y, 0, window->gy);
  int16 above = squared(gradients_of(r0, r1, r2));
  int16 here = squared(middle);
  int16 below = squared(gradients_of(r2, r3, r4));
  if (row == 0) above = 0;
  if (row == last) below = 0;
  if (x < 0 || x + CYL_WINDOW > frame->width) {
    const int16 column = x + (int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const int16 exists = column >= 0 && column < frame->width;
    above &= exists;
    here &= exists;
    below &= exists;
  }
  vstore16(above, 0, window->squares);
  vstore16(here, 1, window->squares);
  vstore16(below, 2, window->squares);
}

// From a pixel to the neighbour in the gradient's direction, to the nearest of eight; as a step in Window::squares.
static int step_along(int gx, int gy) {
  const int tan22 = 13573;  // tan(22.5 deg) in 1/2^15
  const int one = 1 << 15;
  const int ax = (int)abs(gx);
  const int ay = (int)abs(gy);
  const int step_x = gx < 0 ? -1 : 1;
  const int step_y = gy < 0 ? -CYL_WINDOW : CYL_WINDOW;
  if (ay * one < ax * tan22) return step_x;
  if (ay * one > ax * (tan22 + 2 * one)) return step_y;  // tan(67.5 deg) = tan(22.5 deg) + 2
  return step_x + step_y;
}

// Light of the pixels that show a part's colour.
typedef struct {
  ulong r;
  ulong g;
  ulong b;
} LightSum;

static bool shows_part(const KernelGate* gate, int r, int g, int b) {
  const int high = max(max(r, g), b);
  const int low = min(min(r, g), b);
  const int side_a = gate->a_r * (r - g) + gate->a_b * (b - g) + gate->bias;
  const int side_b = gate->b_r * (r - g) + gate->b_b * (b - g) + gate->bias;
  const bool hue = ((side_a | side_b) >= 0) != (gate->invert != 0);
  return hue && high >= gate->value && (high - low) * 256 >= gate->saturation_256 * high && high < 255;
}

static void add_light(LightSum* sum, const Line* line, const KernelGate* gate, const global ushort* light) {
  const int first = pixels_along(line, CYL_INWARD);
  for (int k = first; k <= first + 1; ++k) {
    const global uchar* pixel = pixel_of_line(line, k);
    const int r = red_of(pixel);
    const int g = green_of(pixel);
    const int b = blue_of(pixel);
    if (!shows_part(gate, r, g, b)) continue;
    sum->r += light[r];
    sum->g += light[g];
    sum->b += light[b];
  }
}

// 64-bit addition with 32-bit atomics: whoever makes the low half wrap carries into the high half.
static void add_to_color(global ColorSum* sum, int channel, ulong value) {
  const uint low = (uint)value;
  const uint carry = atomic_add(&sum->low[channel], low) > ~low ? 1 : 0;
  const uint high = (uint)(value >> 32) + carry;
  if (high != 0) atomic_add(&sum->high[channel], high);
}

// The edge pixels among `band`, whose bit i is the pixel in lane i + CYL_WINDOW_MARGIN of the window.
static void find_in_window(const Window* window, uint band, const global uchar* image, const KernelFrame* frame,
                           const KernelGate* gate, const global ushort* light, int part, int x, int row,
                           LightSum* sum, global uchar* result) {
  KernelEdge found[CYL_WINDOW_PIXELS];
  uint count = 0;
  for (uint left = band; left != 0; left &= left - 1) {
    const int lane = lowest_bit(left) + CYL_WINDOW_MARGIN;
    const int here = window->squares[CYL_WINDOW + lane];
    if (here < frame->weak) continue;
    const int gx = window->gx[lane];
    const int gy = window->gy[lane];
    const int step = step_along(gx, gy);
    if (here <= window->squares[CYL_WINDOW + lane + step] || here < window->squares[CYL_WINDOW + lane - step]) {
      continue;
    }
    const int cosine = cosine_of(gx, gy);
#if CYL_CHANNELS != 1
    if (here >= frame->strong) {
      const Line line = line_through(image, frame, x + lane, row, gx, gy, cosine);
      add_light(sum, &line, gate, light);
    }
#endif
    KernelEdge* edge = &found[count++];
    edge->x = (short)(frame->origin_x + x + lane);
    edge->y = (short)(frame->origin_y + row);
    edge->gx = (short)gx;
    edge->gy = (short)gy;
    edge->offset_256 = (short)cosine;
    edge->kind = (ushort)(32 * part + (here >= frame->strong ? 2 : 1));
  }
  if (count == 0) return;
  const uint at = atomic_add(&header_of(result)->edges, count);
  global KernelEdge* edges = edges_of(result, frame);
  for (uint i = 0; i < count && at + i < frame->edge_capacity; ++i) edges[at + i] = found[i];
}

CYL_KERNEL void find_edges(const global uchar* image, const KernelFrame frame, const global KernelGate* gates,
                           const global ushort* light_tables, const global ulong* masks, global uchar* result) {
  const global ushort* light = light_tables + frame.light_table;
  const int words = words_in_row(&frame);
  const uint rows = (uint)(frame.end_row - frame.first_row);
  const uint units = rows * (uint)frame.parts;
  // Rows with edges lie together: taken in turns, they spread over the work-items.
  for (uint unit = (uint)get_global_id(0); unit < units; unit += (uint)get_global_size(0)) {
    const int part = (int)(unit / rows);
    const int row = frame.first_row + (int)(unit % rows);
    const global ulong* mask = masks + row_of_plane(&frame, part, frame.plane_row);
    const KernelGate gate = gates[part];
    LightSum sum = {0, 0, 0};
    for (int block = 0; block < words; block += 8) {
      ulong bands[8];
      if (!band_of_block(bands, mask, &frame, row, block)) continue;
      for (int i = 0; i < 8; ++i) {
        for (ulong band = bands[i]; band != 0;) {
          const int first = lowest_bit(band);
          const uint in_window = (uint)(band >> first) & ((1U << CYL_WINDOW_PIXELS) - 1);
          const int x = (block + i) * 64 + first - CYL_WINDOW_MARGIN;
          Window window;
          fill_window(&window, image, &frame, &gate, x, row);
          find_in_window(&window, in_window, image, &frame, &gate, light, part, x, row, &sum, result);
          band &= ~((ulong)in_window << first);
        }
      }
    }
    if ((sum.r | sum.g | sum.b) != 0) {
      global ColorSum* color = color_sums_of(result) + part;
      add_to_color(color, 0, sum.r);
      add_to_color(color, 1, sum.g);
      add_to_color(color, 2, sum.b);
    }
  }
}
