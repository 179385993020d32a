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

static Colors colors_of(uchar16 v0, uchar16 v1, uchar16 v2) {
  const uchar16 first = (uchar16)(v0.s0369, v0.scf, v1.s258b, v1.se, v2.s147a, v2.sd);
  const uchar16 second = (uchar16)(v0.s147a, v0.sd, v1.s0369, v1.scf, v2.s258b, v2.se);
  const uchar16 third = (uchar16)(v0.s258b, v0.se, v1.s147a, v1.sd, v2.s0369, v2.scf);
  Colors colors;
  colors.red = CYL_RED == 0 ? first : third;
  colors.green = second;
  colors.blue = CYL_RED == 0 ? third : first;
  return colors;
}

static Colors load_colors(const global uchar* pixel) {
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
