// Structs that kernels and host code share: the same members at the same places in OpenCL C 1.2 and in C++.
// Members go from large to small, so that neither side adds padding but at the end.
#ifndef CYLPOSE_TYPES_H
#define CYLPOSE_TYPES_H

#ifdef __OPENCL_VERSION__
typedef short CylI16;
typedef ushort CylU16;
typedef int CylI32;
typedef uint CylU32;
typedef long CylI64;
typedef ulong CylU64;
#else
#include <cstdint>
namespace cylpose::opencl {
using CylI16 = std::int16_t;
using CylU16 = std::uint16_t;
using CylI32 = std::int32_t;
using CylU32 = std::uint32_t;
using CylI64 = std::int64_t;
using CylU64 = std::uint64_t;
#endif

// What a run of the kernels works on: a strip of rows of the search rectangle. Rows and columns count from the
// rectangle's first pixel; only what comes back is in frame coordinates.
//
//        0                       width
//      0 +-------------------------+
//        |                         |
//        |.........................| image_row    the image buffer starts here (locating looks 14 rows around an edge)
//        |- - - - - - - - - - - - -| plane_row    the bit planes start here: first_row - 4, cut to the rectangle
//        |=========================| first_row
//        |    rows of this run     |
//        |=========================| end_row
//        |- - - - - - - - - - - - -| end_row + 4, cut to the rectangle
// height +-------------------------+
typedef struct {
  CylI64 image_stride;  // bytes from one row of the image to the next
  CylI32 origin_x;      // frame coordinates of the rectangle's first pixel
  CylI32 origin_y;
  CylI32 width;  // of the rectangle; pixels outside it do not exist
  CylI32 height;
  CylI32 image_row;
  CylI32 plane_row;
  CylI32 plane_rows;
  CylI32 first_row;
  CylI32 end_row;
  CylI32 pitch;          // words from one row of a plane to the next; a multiple of 8
  CylI32 parts;          // bit planes
  CylI32 weak;           // squared Sobel magnitude from which an edge is weak
  CylI32 strong;         // ... strong
  CylI32 light_table;    // index of the first entry of the light table to use
  CylU32 edge_capacity;  // edges that the result has room for
  CylU32 rows_at;        // bytes from the start of the result to RowStatistics[parts][end_row - first_row]
  CylU32 edges_at;       // bytes from the start of the result to KernelEdge[edge_capacity]
  CylU32 stamp;          // comes back in ResultHeader when the last kernel has run
} KernelFrame;

// The colour gate of a part, for tests without branches: a pixel's hue is in the range when
// invert != (a_r (R-G) + a_b (B-G) + bias >= 0 and b_r (R-G) + b_b (B-G) + bias >= 0).
typedef struct {
  CylI32 a_r;
  CylI32 a_b;
  CylI32 b_r;
  CylI32 b_b;
  CylI32 bias;            // 0 or -1
  CylI32 invert;          // 0 or 1
  CylI32 any_hue;         // response: 1 for max - min or max, 0 for the share of the mid hue
  CylI32 saturation_256;  // floor of (max - min) / max, 0..256
  CylI32 value;           // floor of max, 0..255
  CylI32 response_r;
  CylI32 response_b;
  CylI32 aside_r;
  CylI32 aside_b;
} KernelGate;

// Start of the result; ColorSum[parts] follows.
typedef struct {
  CylU32 stamp;
  CylU32 edges;  // edges found; those beyond edge_capacity are counted but not kept
} ResultHeader;

// Light of the pixels that show a part's colour, 64-bit sums in two halves (red, green, blue).
typedef struct {
  CylU32 low[3];
  CylU32 high[3];
} ColorSum;

// One row of a part's mask: sums over its pixels, x in frame coordinates.
typedef struct {
  CylU64 sum_xx;
  CylU32 sum_x;
  CylU32 count;
  CylU32 left;   // first column of the mask; undefined in an empty row
  CylU32 right;  // first column after it
} RowStatistics;

// An edge pixel in frame coordinates; EdgePixel on the host.
typedef struct {
  CylI16 x;
  CylI16 y;
  CylI16 gx;
  CylI16 gy;
  CylI16 offset_256;  // between finding and locating: the cosine of the edge's line (line.cl)
  CylU16 kind;  // 32 * part + 4 * cue + strength (EdgeCue, EdgeStrength); no cue before locating
} KernelEdge;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(KernelFrame) == 80 && sizeof(KernelGate) == 52 && sizeof(ResultHeader) == 8);
static_assert(sizeof(ColorSum) == 24 && sizeof(RowStatistics) == 24 && sizeof(KernelEdge) == 12);
}  // namespace cylpose::opencl
#endif

#endif
