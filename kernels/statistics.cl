// Sums over the set pixels of one row of a mask, from its runs:
//
//   bits     0 0 1 1 1 1 0 0 0 1 1 0       a run from `first` to before `end`
//   flips        ^       ^     ^   ^       where a bit differs from the one before it
//
// A run contributes S(end) - S(first), where S(x) sums over 0 .. x-1; so each flip adds or takes one S, and words
// without flips cost nothing. Border rule: the bits before and after the row are 0.

typedef struct {
  uint count;
  uint sum_x;    // below 32768^2 / 2
  ulong sum_xx;  // below 32768^3 / 3
  uint left;
  uint right;
} RowSums;

static void add_flip(RowSums* sums, ulong x, bool first) {
  const uint ones = (uint)x;
  const uint linear = (uint)(x * (x - 1) / 2);
  const ulong squares = x * (x - 1) * (2 * x - 1) / 6;
  // Unsigned, so that taking before adding wraps around and back.
  sums->count += first ? -ones : ones;
  sums->sum_x += first ? -linear : linear;
  sums->sum_xx += first ? -squares : squares;
  if (first) {
    sums->left = min(sums->left, ones);
  } else {
    sums->right = ones;
  }
}

static void store_row_statistics(const global ulong* row, const KernelFrame* frame, global RowStatistics* statistics) {
  RowSums sums = {0, 0, 0, ~0U, 0};
  ulong before = 0;  // the last bit of the word before
  for (int block = 0; block < frame->pitch; block += 8) {
    if (before == 0 && !any_bit(vload8(0, row + block))) continue;
    for (int word = block; word < block + 8; ++word) {
      const ulong bits = row[word];
      for (ulong flips = bits ^ ((bits << 1) | before); flips != 0; flips &= flips - 1) {
        const int bit = lowest_bit(flips);
        add_flip(&sums, (ulong)(frame->origin_x + word * 64 + bit), (bits >> bit & 1) != 0);
      }
      before = bits >> 63;
    }
  }
  if (before != 0) add_flip(&sums, (ulong)(frame->origin_x + frame->width), false);
  statistics->sum_xx = sums.sum_xx;
  statistics->sum_x = sums.sum_x;
  statistics->count = sums.count;
  statistics->left = sums.left;
  statistics->right = sums.right;
}
