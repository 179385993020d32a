// The row or column of pixels through an edge pixel, whichever is nearer to the gradient:
//
//              outside                    part
//   k =  ... -4 -3 -2 -1   0   1  2  3  4 ...       pixel k is k steps inward of the edge pixel
//
// Border rule: pixels outside the rectangle repeat the nearest one inside.
// The integers are those of the host's locate.cpp, step by step.

#define CYL_UNIT (1 << 12)     // length of a unit normal; lengths along the normal are in 1/CYL_UNIT pixels
#define CYL_SUBPIXEL (1 << 8)  // offsets

typedef struct {
  int x;  // column and row of the edge pixel
  int y;
  int step_x;  // to the next pixel inward
  int step_y;
  int cosine;  // between line and gradient, in 1/CYL_UNIT
} Line;

// To the nearest, halves away from zero; `denominator` > 0.
static long rounded_quotient(long numerator, long denominator) {
  return (numerator >= 0 ? numerator + denominator / 2 : numerator - denominator / 2) / denominator;
}

// Floor of the square root of a value below 2^42. The float is at most a few units off, whatever the device's
// precision; integers put it right.
static uint integer_root(ulong value) {
  ulong root = (ulong)sqrt((float)value);
  while (root * root > value) --root;
  while ((root + 1) * (root + 1) <= value) ++root;
  return (uint)root;
}

// The gradient must not be zero.
static Line line_through(int x, int y, int gx, int gy) {
  const int fraction_bits = 10;  // of the gradient's length
  const ulong squared = (ulong)(gx * gx + gy * gy);
  const uint length = integer_root(squared << (2 * fraction_bits));
  const bool along_row = abs(gx) >= abs(gy);
  const int along = along_row ? gx : gy;
  Line line;
  line.x = x;
  line.y = y;
  line.step_x = along_row ? (along < 0 ? -1 : 1) : 0;
  line.step_y = along_row ? 0 : (along < 0 ? -1 : 1);
  line.cosine = (int)rounded_quotient(((long)abs(along) << fraction_bits) * CYL_UNIT, length);
  return line;
}

// Pixels along the line that reach so far along the gradient, in 1/CYL_UNIT.
static int pixels_along(const Line* line, int along_gradient) {
  return (along_gradient + line->cosine / 2) / line->cosine;
}

// The k-th pixel inward.
static const global uchar* pixel_of_line(const global uchar* image, const KernelFrame* frame, const Line* line,
                                         int k) {
  const int x = clamp(line->x + k * line->step_x, 0, frame->width - 1);
  const int y = clamp(line->y + k * line->step_y, 0, frame->height - 1);
  return image_row(image, frame, y) + x * CYL_CHANNELS;
}

static int red_of(const global uchar* pixel) {
  return pixel[CYL_CHANNELS == 1 ? 0 : CYL_RED];
}
static int green_of(const global uchar* pixel) {
  return pixel[CYL_CHANNELS == 1 ? 0 : 1];
}
static int blue_of(const global uchar* pixel) {
  return pixel[CYL_CHANNELS == 1 ? 0 : CYL_BLUE];
}
