// Opening of a bit plane: 3x3 erosion, then 3x3 dilation; 64 pixels at a time.
//
//   row y-2   h h h              h: AND of each bit with its two neighbours in the row
//   row y-1   h h h   e e e      e: AND of h over three rows = eroded
//   row y     h h h   e e e   d  d: OR of e over three rows; OR of d with its two neighbours = opened
//   row y+1   h h h   e e e
//   row y+2   h h h
//
// Every e around row y holds h of row y itself: where a word of row y is 0, so is d, and nothing else is looked at.
// Border rule: pixels outside the rectangle do not exist; they neither erode nor dilate.

// AND of the bits of a word with their neighbours in the row. A row that does not exist erodes nothing.
static ulong eroded_in_row(const global ulong* plane, const KernelFrame* frame, int row, int word) {
  if (!row_exists(frame, row)) return ~0UL;
  const int words = words_in_row(frame);
  const global ulong* bits = plane + row_of_plane(frame, 0, row) + word;
  const ulong outside = ~pixels_of_word(frame, word);
  const ulong here = *bits | outside;
  const ulong before = word > 0 ? bits[-1] >> 63 : 1;
  const ulong after = word + 1 < words ? bits[1] << 63 : 1UL << 63;
  return here & ((here << 1) | before) & ((here >> 1) | after);
}

// OR over three rows of the eroded plane.
static ulong opened_in_column(const global ulong* plane, const KernelFrame* frame, int row, int word) {
  const ulong h0 = eroded_in_row(plane, frame, row - 2, word);
  const ulong h1 = eroded_in_row(plane, frame, row - 1, word);
  const ulong h2 = eroded_in_row(plane, frame, row, word);
  const ulong h3 = eroded_in_row(plane, frame, row + 1, word);
  const ulong h4 = eroded_in_row(plane, frame, row + 2, word);
  ulong opened = h1 & h2 & h3;
  if (row_exists(frame, row - 1)) opened |= h0 & h1 & h2;
  if (row_exists(frame, row + 1)) opened |= h2 & h3 & h4;
  return opened & pixels_of_word(frame, word);
}

// Opened planes for the rows of the strip and CYL_MASK_HALO around them; statistics for the rows of the strip.
CYL_KERNEL void opening(const KernelFrame frame, const global ulong* planes, global ulong* masks,
                        global uchar* result) {
  const int words = words_in_row(&frame);
  const int first_row = max(frame.first_row - CYL_MASK_HALO, 0);
  const int end_row = min(frame.end_row + CYL_MASK_HALO, frame.height);
  const uint rows = (uint)(end_row - first_row);
  const uint units = rows * (uint)frame.parts;
  const uint end_unit = share_begin(units, get_global_id(0) + 1, get_global_size(0));
  for (uint unit = share_begin(units, get_global_id(0), get_global_size(0)); unit < end_unit; ++unit) {
    const int part = (int)(unit / rows);
    const int row = first_row + (int)(unit % rows);
    const global ulong* plane = planes + row_of_plane(&frame, part, frame.plane_row);
    const global ulong* gated = planes + row_of_plane(&frame, part, row);
    global ulong* mask = masks + row_of_plane(&frame, part, row);
    for (int block = 0; block < frame.pitch; block += 8) vstore8((ulong8)0, 0, mask + block);
    for (int block = 0; block < frame.pitch; block += 8) {
      if (!any_bit(vload8(0, gated + block))) continue;
      for (int word = block; word < block + 8; ++word) {
        if (gated[word] == 0) continue;
        const ulong column = opened_in_column(plane, &frame, row, word);
        if (column == 0) continue;
        mask[word] |= (column | (column << 1) | (column >> 1)) & pixels_of_word(&frame, word);
        if (word > 0) mask[word - 1] |= column << 63;
        if (word + 1 < words) mask[word + 1] |= column >> 63;
      }
    }
    if (row >= frame.first_row && row < frame.end_row) {
      const int own_rows = frame.end_row - frame.first_row;
      store_row_statistics(mask, &frame, rows_of(result, &frame) + part * own_rows + (row - frame.first_row));
    }
  }
}
