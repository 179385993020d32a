// The messages of wire.fbs as our own types: written, and read only after they were verified.
#pragma once

#include <flatbuffers/flatbuffers.h>

#include <cstdint>
#include <cylpose/backend.hpp>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace cylpose::cluster {

using Buffer = flatbuffers::DetachedBuffer;
using Bytes = std::span<const std::uint8_t>;

/// Raised with every change of wire.fbs or of what its fields mean.
inline constexpr std::uint32_t kProtocol = 1;

/// Most parts in a tile.
inline constexpr std::size_t kMostTileParts = 256;

/// What a tile's message needs beyond its pixels, at most.
inline constexpr std::size_t kTileOverhead = 1024 + kMostTileParts * 4 * sizeof(double);

/// Work for a node: find the edges in `rows` of the image, all of which is searched.
struct Tile {
  std::uint64_t id = 0;
  ImageView image;  ///< read: points into the message's bytes
  Rows rows;        ///< lies in the image, not empty
  int edge_low = 1;
  int edge_high = 1;
  std::vector<PartModel> parts;  ///< valid; names and sizes say nothing
};

struct TileResult {
  std::uint64_t id = 0;
  double busy_ms = 0;            ///< that the node worked on it
  std::string error;             ///< why there are no parts; empty when there are
  std::vector<PartEdges> parts;  ///< in the tile's coordinates, offsets 0
};

/// A node asks for tiles.
struct Hello {
  std::string node;  ///< name.random
  int slots = 0;     ///< most tiles that it wants at a time; 0: it leaves
  double pixels_per_ms = 0;
};

struct Refusal {
  std::string reason;
};

/// Moved, never copied: a tile may point into its `aligned`.
struct Message {
  Message() = default;
  Message(Message&&) = default;
  Message& operator=(Message&&) = default;

  std::uint32_t protocol = 0;
  std::string kernels;
  /// Empty when `protocol` is not ours.
  std::variant<std::monostate, Tile, TileResult, Hello, Refusal> body;
  std::vector<std::uint64_t> aligned;  ///< the bytes, where they did not lie as FlatBuffers reads them
};

/// `image` is copied row by row.
[[nodiscard]] Buffer encode(const Tile& tile);
[[nodiscard]] Buffer encode(const TileResult& result);
[[nodiscard]] Buffer encode(const Hello& hello);
[[nodiscard]] Buffer encode(const Refusal& refusal);

/// Throws Error(kInput) for anything that is not a valid message: damaged or truncated, sizes that do not fit each
/// other, values out of range. `bytes` and the message must live as long as a Tile that was read from them.
[[nodiscard]] Message decode(Bytes bytes);

/// Why a message of that origin cannot be used here; empty when it can. `whose` names it.
[[nodiscard]] std::string version_conflict(const Message& message, const std::string& whose);

/// Throws Error(kInput) unless the result can be that of the tile: its parts, edges in its rows in row-major order,
/// statistics of a mask of that size.
void require_fits(const TileResult& result, int width, const Rows& rows, std::size_t parts);

}  // namespace cylpose::cluster
