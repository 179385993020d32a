// Where things lie in the buffers, and how a kernel's work is shared out. Used by all stages.
//
// Bit plane: one bit per pixel, pixel x of a row is bit x % 64 of word x / 64. Bits and words beyond the width are 0.
// A row of `pitch` words per row of the strip, plane after plane:
//
//   word     0        1              pitch-1
//        +--------+--------+- - -+--------+
//        | 0..63  | 64..127|     | 0    0 |   row plane_row of part 0
//        +--------+--------+- - -+--------+
//        ...                                  plane_rows rows, then part 1
//
// Result: ResultHeader | ColorSum[parts] | RowStatistics[parts][rows] | KernelEdge[edge_capacity]

// Work-items of a work-group. Constraint: at least 1 and at most what the device allows. CPU: 1, since every work-item
// uses vectors itself; GPU: a multiple of the device's preferred size.
#ifndef CYL_GROUP_SIZE
#define CYL_GROUP_SIZE 1
#endif

#define CYL_KERNEL kernel __attribute__((reqd_work_group_size(CYL_GROUP_SIZE, 1, 1)))

// For functions with vectors in the innermost loops: a call would take them through memory. `static` for Oclgrind, which
// does not know what clang writes where it inlines functions that return structs.
#ifndef CYL_INLINE
#define CYL_INLINE static inline __attribute__((always_inline))
#endif

// Rows of the mask that a strip needs around its own (band), and of the gate's plane (opening). Fixed by the stages.
#define CYL_MASK_HALO 2
#define CYL_GATE_HALO 4

static int words_in_row(const KernelFrame* frame) {
  return (frame->width + 63) >> 6;
}

// The bits of word `word` that are pixels.
static ulong pixels_of_word(const KernelFrame* frame, int word) {
  const int left = frame->width - (word << 6);
  return left >= 64 ? ~0UL : (1UL << left) - 1;
}

static bool row_exists(const KernelFrame* frame, int row) {
  return row >= 0 && row < frame->height;
}

// Index of the first word of a plane's row.
static size_t row_of_plane(const KernelFrame* frame, int part, int row) {
  return ((size_t)part * (size_t)frame->plane_rows + (size_t)(row - frame->plane_row)) * (size_t)frame->pitch;
}

static const global uchar* image_row(const global uchar* image, const KernelFrame* frame, int row) {
  return image + (long)(row - frame->image_row) * frame->image_stride;
}

static global ResultHeader* header_of(global uchar* result) {
  return (global ResultHeader*)result;
}

static global ColorSum* color_sums_of(global uchar* result) {
  return (global ColorSum*)(result + sizeof(ResultHeader));
}

static global RowStatistics* rows_of(global uchar* result, const KernelFrame* frame) {
  return (global RowStatistics*)(result + frame->rows_at);
}

static global KernelEdge* edges_of(global uchar* result, const KernelFrame* frame) {
  return (global KernelEdge*)(result + frame->edges_at);
}

// A work-item's share of `units` pieces of work is [begin, end): neighbours stay together.
static uint share_begin(uint units, size_t item, size_t items) {
  return (uint)((ulong)units * item / items);
}

// Index of the lowest set bit; `word` != 0.
static int lowest_bit(ulong word) {
  return 63 - (int)clz(word & (~word + 1));
}

static bool any_bit(ulong8 words) {
  const ulong4 four = words.lo | words.hi;
  const ulong2 two = four.lo | four.hi;
  return (two.x | two.y) != 0;
}
