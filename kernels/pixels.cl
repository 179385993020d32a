// Sixteen pixels at a time: interleaved bytes in, one vector a channel out.
//
//   BGR8 bytes   b g r b g r b g r ...   48 bytes, three loads
//   blue         b b b ...               16 lanes
//   green        g g g ...
//   red          r r r ...
//
// The loads are spelled out because compilers do not vectorise three interleaved bytes by themselves.
// Border rule: load_colors reads 16 pixels that exist; gather_colors repeats the first and last pixel of the row.

// Bytes per pixel: 3 (colour) or 1 (grey).
#ifndef CYL_CHANNELS
#define CYL_CHANNELS 3
#endif

// Byte of red within a colour pixel: 2 (BGR8) or 0 (RGB8). Blue is the other one.
#ifndef CYL_RED
#define CYL_RED 2
#endif

#define CYL_BLUE (2 - CYL_RED)

typedef struct {
  uchar16 red;  // of a grey image all three are the one code there is
  uchar16 green;
  uchar16 blue;
} Colors;

// A channel's bytes lie at other places in each of three vectors, one of
//   A: 0 3 6 9 12 15    B: 1 4 7 10 13    C: 2 5 8 11 14
// so masks gather them in one vector, and one shuffle of that brings them in order.
CYL_INLINE uchar16 merged(uchar16 a, uchar16 b, uchar16 c) {
  const uchar16 places_a = (uchar16)(0xFF, 0, 0, 0xFF, 0, 0, 0xFF, 0, 0, 0xFF, 0, 0, 0xFF, 0, 0, 0xFF);
  const uchar16 places_b = (uchar16)(0, 0xFF, 0, 0, 0xFF, 0, 0, 0xFF, 0, 0, 0xFF, 0, 0, 0xFF, 0, 0);
  const uchar16 places_c = (uchar16)(0, 0, 0xFF, 0, 0, 0xFF, 0, 0, 0xFF, 0, 0, 0xFF, 0, 0, 0xFF, 0);
  return (a & places_a) | (b & places_b) | (c & places_c);
}

CYL_INLINE Colors colors_of(uchar16 v0, uchar16 v1, uchar16 v2) {
  const uchar16 first = merged(v0, v2, v1).s0369cf258be147ad;
  const uchar16 second = merged(v1, v0, v2).s147ad0369cf258be;
  const uchar16 third = merged(v2, v1, v0).s258be147ad0369cf;
  Colors colors;
  colors.red = CYL_RED == 0 ? first : third;
  colors.green = second;
  colors.blue = CYL_RED == 0 ? third : first;
  return colors;
}

CYL_INLINE Colors load_colors(const global uchar* pixel) {
#if CYL_CHANNELS == 1
  const uchar16 code = vload16(0, pixel);
  Colors colors;
  colors.red = code;
  colors.green = code;
  colors.blue = code;
  return colors;
#else
  return colors_of(vload16(0, pixel), vload16(1, pixel), vload16(2, pixel));
#endif
}

// Columns x to x + 15 of a row, of which any may lie outside.
static Colors gather_colors(const global uchar* row, int x, int width) {
  uchar red[16];
  uchar green[16];
  uchar blue[16];
  for (int i = 0; i < 16; ++i) {
    const global uchar* pixel = row + clamp(x + i, 0, width - 1) * CYL_CHANNELS;
#if CYL_CHANNELS == 1
    red[i] = green[i] = blue[i] = pixel[0];
#else
    red[i] = pixel[CYL_RED];
    green[i] = pixel[1];
    blue[i] = pixel[CYL_BLUE];
#endif
  }
  Colors colors;
  colors.red = vload16(0, red);
  colors.green = vload16(0, green);
  colors.blue = vload16(0, blue);
  return colors;
}

static Colors colors_at(const global uchar* row, int x, int width) {
  if (x >= 0 && x + 16 <= width) return load_colors(row + x * CYL_CHANNELS);
  return gather_colors(row, x, width);
}
