// Colour gate: every pixel is read once and gives one bit per part.
//
//   image row     64 pixels | 64 pixels | ...         a work-item takes a span of words of one row
//   plane part 0  one word  | one word  | ...
//   plane part 1  one word  | one word  | ...
//
// Border rule: a pixel's bit depends on that pixel alone. Bits and words beyond the width are 0.
// All arithmetic fits 16 bits: hue coefficients are at most 64, so |a_r (R-G) + a_b (B-G)| <= 32640, and the two sides
// of the saturation test are at most 65280.

// Words (of 64 pixels) in a work-item's span. Constraint: at least 1. CPU: as many as the longest row has, so that a
// core reads whole rows; GPU: 1, so that neighbours read neighbouring words.
#ifndef CYL_SPAN_WORDS
#define CYL_SPAN_WORDS 512
#endif

// All ones where a pixel is bright and saturated enough, else 0.
CYL_INLINE short16 vivid(const KernelGate* gate, const Colors* colors) {
#if CYL_CHANNELS == 1
  return convert_short16(colors->red) >= (short)gate->value;
#else
  const uchar16 high = max(max(colors->red, colors->green), colors->blue);
  const uchar16 low = min(min(colors->red, colors->green), colors->blue);
  const ushort16 wide_high = convert_ushort16(high);
  const short16 saturated = (convert_ushort16(high - low) << (ushort)8) >= (ushort)gate->saturation_256 * wide_high;
  const short16 bright = wide_high >= (ushort)gate->value;
  return saturated & bright;
#endif
}

// 0xFF where a vivid pixel has a hue of the range, else 0.
CYL_INLINE uchar16 of_hue(const KernelGate* gate, const Colors* colors, short16 is_vivid) {
#if CYL_CHANNELS == 1
  return convert_uchar16(as_ushort16(is_vivid));
#else
  const short16 rg = convert_short16(colors->red) - convert_short16(colors->green);
  const short16 bg = convert_short16(colors->blue) - convert_short16(colors->green);
  const short16 a = (short)gate->a_r * rg + (short)gate->a_b * bg + (short)gate->bias;
  const short16 b = (short)gate->b_r * rg + (short)gate->b_b * bg + (short)gate->bias;
  const short16 hue = ((a | b) >= (short)0) ^ (short)-gate->invert;
  return convert_uchar16(as_ushort16(hue & is_vivid));
#endif
}

// Four times sixteen bytes of 0xFF or 0 to a word, first pixel lowest. The multiplication moves bit 0 of byte i of
// eight to bit i of the highest byte; no two products meet in a bit.
CYL_INLINE ulong packed(uchar16 b0, uchar16 b1, uchar16 b2, uchar16 b3) {
  const ulong8 bytes = (ulong8)(as_ulong2(b0), as_ulong2(b1), as_ulong2(b2), as_ulong2(b3));
  return as_ulong(convert_uchar8(((bytes & 0x0101010101010101UL) * 0x0102040810204080UL) >> 56UL));
}

typedef struct {
  Colors c0;
  Colors c1;
  Colors c2;
  Colors c3;
} WordColors;

// Most of most frames is too grey or too dark for a part: there the hue is not looked at.
CYL_INLINE ulong gated_word(const KernelGate* gate, const WordColors* colors) {
  const short16 v0 = vivid(gate, &colors->c0);
  const short16 v1 = vivid(gate, &colors->c1);
  const short16 v2 = vivid(gate, &colors->c2);
  const short16 v3 = vivid(gate, &colors->c3);
  const ulong4 any = as_ulong4(v0 | v1 | v2 | v3);
  if (((any.x | any.y) | (any.z | any.w)) == 0) return 0;
  return packed(of_hue(gate, &colors->c0, v0), of_hue(gate, &colors->c1, v1), of_hue(gate, &colors->c2, v2),
                of_hue(gate, &colors->c3, v3));
}

CYL_KERNEL void gate(const global uchar* image, const KernelFrame frame, const global KernelGate* gates,
                     global ulong* planes, global uchar* result) {
  if (get_global_id(0) == 0) {  // the counters of the stages to come
    header_of(result)->stamp = 0;
    header_of(result)->edges = 0;
    for (int part = 0; part < frame.parts; ++part) {
      for (int i = 0; i < 3; ++i) {
        color_sums_of(result)[part].low[i] = 0;
        color_sums_of(result)[part].high[i] = 0;
      }
    }
  }

  const int words = words_in_row(&frame);
  const uint spans = (uint)(frame.pitch + CYL_SPAN_WORDS - 1) / CYL_SPAN_WORDS;
  const uint units = (uint)frame.plane_rows * spans;
  const uint end_unit = share_begin(units, get_global_id(0) + 1, get_global_size(0));
  for (uint unit = share_begin(units, get_global_id(0), get_global_size(0)); unit < end_unit; ++unit) {
    const int row = frame.plane_row + (int)(unit / spans);
    const global uchar* pixels = image_row(image, &frame, row);
    const int first_word = (int)(unit % spans) * CYL_SPAN_WORDS;
    const int end_word = min(first_word + CYL_SPAN_WORDS, frame.pitch);
    const int whole_words = frame.width / 64;
    for (int word = first_word; word < min(end_word, whole_words); ++word) {
      const global uchar* at = pixels + word * (64 * CYL_CHANNELS);
      WordColors colors;
      colors.c0 = load_colors(at);
      colors.c1 = load_colors(at + 16 * CYL_CHANNELS);
      colors.c2 = load_colors(at + 32 * CYL_CHANNELS);
      colors.c3 = load_colors(at + 48 * CYL_CHANNELS);
      for (int part = 0; part < frame.parts; ++part) {
        const KernelGate part_gate = gates[part];
        planes[row_of_plane(&frame, part, row) + (size_t)word] = gated_word(&part_gate, &colors);
      }
    }
    if (whole_words < words && whole_words >= first_word && whole_words < end_word) {
      const int x = whole_words * 64;
      WordColors colors;
      colors.c0 = colors_at(pixels, x, frame.width);
      colors.c1 = colors_at(pixels, x + 16, frame.width);
      colors.c2 = colors_at(pixels, x + 32, frame.width);
      colors.c3 = colors_at(pixels, x + 48, frame.width);
      for (int part = 0; part < frame.parts; ++part) {
        const KernelGate part_gate = gates[part];
        planes[row_of_plane(&frame, part, row) + (size_t)whole_words] =
            gated_word(&part_gate, &colors) & pixels_of_word(&frame, whole_words);
      }
    }
    for (int part = 0; part < frame.parts; ++part) {
      global ulong* plane_row = planes + row_of_plane(&frame, part, row);
      for (int word = max(first_word, words); word < end_word; ++word) plane_row[word] = 0;
    }
  }
}
