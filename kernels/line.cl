// The row or column of pixels through an edge pixel, whichever is nearer to the gradient:
//
//              outside                    part
//   k =  ... -4 -3 -2 -1   0   1  2  3  4 ...       pixel k is k steps inward of the edge pixel
//
// Border rule: pixels outside the rectangle repeat the nearest one inside.
// The integers are those of the host's locate.cpp, step by step.

#define CYL_UNIT (1 << 12)     // length of a unit normal; lengths along the normal are in 1/CYL_UNIT pixels
#define CYL_SUBPIXEL (1 << 8)  // offsets

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

// Of the angle between gradient and line, in 1/CYL_UNIT. The gradient must not be zero.
static int cosine_of(int gx, int gy) {
  const int fraction_bits = 10;  // of the gradient's length
  const uint length = integer_root((ulong)(gx * gx + gy * gy) << (2 * fraction_bits));
  const ulong along = (ulong)max(abs(gx), abs(gy)) << fraction_bits;
  return (int)((along * CYL_UNIT + length / 2) / length);
}

typedef struct {
  const global uchar* origin;  // the edge pixel
  long step;                   // bytes from a pixel to the next one inward
  int first;                   // k of the first and last pixel that exist
  int last;
  int cosine;
} Line;

static Line line_through(const global uchar* image, const KernelFrame* frame, int x, int y, int gx, int gy,
                         int cosine) {
  const bool along_row = abs(gx) >= abs(gy);
  const int at = along_row ? x : y;
  const int size = along_row ? frame->width : frame->height;
  const bool forward = (along_row ? gx : gy) >= 0;
  const long next = along_row ? CYL_CHANNELS : frame->image_stride;
  Line line;
  line.origin = image_row(image, frame, y) + x * CYL_CHANNELS;
  line.step = forward ? next : -next;
  line.first = forward ? -at : at + 1 - size;
  line.last = forward ? size - 1 - at : at;
  line.cosine = cosine;
  return line;
}

// Pixels along the line that reach so far along the gradient, in 1/CYL_UNIT.
static int pixels_along(const Line* line, int along_gradient) {
  return (along_gradient + line->cosine / 2) / line->cosine;
}

static const global uchar* pixel_of_line(const Line* line, int k) {
  return line->origin + clamp(k, line->first, line->last) * line->step;
}

// The line with the one on either side, moved along by whole pixels so that a straight border crosses all three near
// the same place.
typedef struct {
  Line middle;
  long before;  // bytes from the middle line's pixel to its neighbour's
  long after;
  int shift;  // of the line after, in pixels inward; the one before goes the other way
} Lines;

static Lines lines_through(const global uchar* image, const KernelFrame* frame, int x, int y, int gx, int gy,
                           int cosine) {
  const bool along_row = abs(gx) >= abs(gy);
  const int along = along_row ? gx : gy;
  const int across = along_row ? gy : gx;
  const int at = along_row ? y : x;
  const int size = along_row ? frame->height : frame->width;
  const long next = along_row ? frame->image_stride : CYL_CHANNELS;
  Lines lines;
  lines.middle = line_through(image, frame, x, y, gx, gy, cosine);
  lines.before = at > 0 ? -next : 0;
  lines.after = at + 1 < size ? next : 0;
  lines.shift = 2 * abs(across) <= abs(along) ? 0 : across < 0 ? 1 : -1;
  return lines;
}

static const global uchar* pixel_beside(const Lines* lines, int side, int k) {
  return pixel_of_line(&lines->middle, k + side * lines->shift) + (side < 0 ? lines->before : lines->after);
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
