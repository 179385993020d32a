#include "message.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <cylpose/error.hpp>
#include <cylpose/opencl_devices.hpp>

#include "wire_generated.h"

namespace cylpose::cluster {
namespace {

constexpr int kLongestSide = 32767;  // of an image (require_usable)

[[noreturn]] void refuse(const std::string& what) {
  throw Error(ErrorKind::kInput, "cluster message: " + what);
}

void require(bool holds, const char* what) {
  if (!holds) refuse(what);
}

template <typename Body>
Buffer finished(flatbuffers::FlatBufferBuilder& builder, wire::Body type, flatbuffers::Offset<Body> body) {
  const auto kernels = builder.CreateString(std::string(kernel_hash()));
  builder.Finish(wire::CreateMessage(builder, kProtocol, kernels, type, body.Union()), wire::MessageIdentifier());
  return builder.Release();
}

PartModel part_of(const wire::PartColor& color) {
  PartModel part{"part", 1, 1, color.hue_lo_deg(), color.hue_hi_deg(), color.min_saturation(), color.min_value()};
  if (std::string why; !part.is_valid(&why)) refuse("a part's colours: " + why);
  return part;
}

Tile tile_of(const wire::Tile& read) {
  Tile tile;
  tile.id = read.id();
  require(read.format() <= static_cast<std::uint8_t>(PixelFormat::kGray8), "unknown pixel format");
  tile.image.format = static_cast<PixelFormat>(read.format());
  tile.image.width = read.width();
  tile.image.height = read.height();
  tile.image.stride = std::ptrdiff_t{tile.image.width} * bytes_per_pixel(tile.image.format);
  tile.rows = {read.first_row(), read.end_row()};
  tile.edge_low = read.edge_low();
  tile.edge_high = read.edge_high();
  require(tile.image.width > 0 && tile.image.width <= kLongestSide && tile.image.height > 0 &&
              tile.image.height <= kLongestSide,
          "a tile has 1 to 32767 rows and columns");
  require(tile.rows.first < tile.rows.end && tile.rows.end <= tile.image.height, "rows lie in the tile");
  require(tile.edge_low >= 1 && tile.edge_low <= tile.edge_high, "edge_low is 1 to edge_high");
  require(read.pixels() != nullptr && read.pixels()->size() == static_cast<std::size_t>(tile.image.stride) *
                                                                   static_cast<std::size_t>(tile.image.height),
          "a tile has as many pixels as its size says");
  tile.image.data = read.pixels()->data();
  require(read.parts() != nullptr && read.parts()->size() > 0 && read.parts()->size() <= kMostTileParts,
          "a tile is searched for 1 to 256 parts");
  // The verifier of FlatBuffers looks at where a vector's length lies, not at where its elements do.
  require(reinterpret_cast<std::uintptr_t>(read.parts()->Data()) % alignof(wire::PartColor) == 0,
          "a part's colours lie at a multiple of 8 bytes");
  for (const wire::PartColor* color : *read.parts()) tile.parts.push_back(part_of(*color));
  return tile;
}

PartEdges part_of(const wire::Part& read) {
  PartEdges part;
  require(read.region() != nullptr, "a part has its statistics");
  const wire::Region& region = *read.region();
  part.region = {region.m00(),
                 region.m10(),
                 region.m01(),
                 region.m20(),
                 region.m11(),
                 region.m02(),
                 {region.x(), region.y(), region.width(), region.height()}};
  if (read.edges() == nullptr) return part;
  part.edges.reserve(read.edges()->size());
  for (const wire::Edge* edge : *read.edges()) {
    require(edge->strength() == 1 || edge->strength() == 2, "an edge is weak or strong");
    part.edges.push_back(
        {edge->x(), edge->y(), edge->gx(), edge->gy(), 0, static_cast<EdgeStrength>(edge->strength())});
  }
  return part;
}

TileResult result_of(const wire::Result& read) {
  TileResult result;
  result.id = read.id();
  result.busy_ms = read.busy_us() * 1e-3;
  if (read.error() != nullptr) result.error = read.error()->str();
  if (read.parts() == nullptr) return result;
  for (const wire::Part* part : *read.parts()) result.parts.push_back(part_of(*part));
  return result;
}

// A node's name becomes part of subjects: two words without wildcards.
bool is_node(const std::string& node) {
  constexpr std::size_t kLongest = 96;
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  };
  const std::size_t dot = node.find('.');
  return node.size() <= kLongest && dot != std::string::npos && dot > 0 && dot + 1 < node.size() &&
         std::all_of(node.begin(), node.begin() + static_cast<std::ptrdiff_t>(dot), plain) &&
         std::all_of(node.begin() + static_cast<std::ptrdiff_t>(dot) + 1, node.end(), plain);
}

Hello hello_of(const wire::Hello& read) {
  constexpr int kMostSlots = 64;
  require(read.node() != nullptr && is_node(read.node()->str()), "a node is two words joined by a dot");
  require(read.slots() <= kMostSlots, "a node asks for at most 64 tiles");
  require(read.pixels_per_ms() >= 0 && read.pixels_per_ms() < 1e12F, "a node's rate is a number");
  return {read.node()->str(), read.slots(), static_cast<double>(read.pixels_per_ms())};
}

// FlatBuffers reads integers in place: from addresses that are multiples of their size. A server's client hands over
// bytes that lie anywhere.
Bytes aligned(Bytes bytes, std::vector<std::uint64_t>* storage) {
  if (bytes.empty() || reinterpret_cast<std::uintptr_t>(bytes.data()) % alignof(std::uint64_t) == 0) return bytes;
  storage->resize(bytes.size() / sizeof(std::uint64_t) + 1);
  std::memcpy(storage->data(), bytes.data(), bytes.size());
  return {reinterpret_cast<const std::uint8_t*>(storage->data()), bytes.size()};
}

}  // namespace

Buffer encode(const Tile& tile) {
  const ImageView& image = tile.image;
  const auto row_bytes =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(bytes_per_pixel(image.format));
  const std::size_t bytes = row_bytes * static_cast<std::size_t>(image.height);
  flatbuffers::FlatBufferBuilder builder(bytes + kTileOverhead);
  std::uint8_t* out = nullptr;
  const auto pixels = builder.CreateUninitializedVector(bytes, 1, &out);
  for (int y = 0; y < image.height; ++y, out += row_bytes) std::memcpy(out, image.row(y), row_bytes);
  std::vector<wire::PartColor> colors;
  colors.reserve(tile.parts.size());
  for (const PartModel& part : tile.parts) {
    colors.emplace_back(part.hue_lo_deg, part.hue_hi_deg, part.min_saturation, part.min_value);
  }
  const auto parts = builder.CreateVectorOfStructs(colors);
  const auto body = wire::CreateTile(
      builder, tile.id, static_cast<std::uint8_t>(image.format), static_cast<std::uint16_t>(image.width),
      static_cast<std::uint16_t>(image.height), static_cast<std::uint16_t>(tile.rows.first),
      static_cast<std::uint16_t>(tile.rows.end), static_cast<std::uint8_t>(tile.edge_low),
      static_cast<std::uint8_t>(tile.edge_high), parts, flatbuffers::Offset<flatbuffers::Vector<std::uint8_t>>(pixels));
  return finished(builder, wire::Body_Tile, body);
}

Buffer encode(const TileResult& result) {
  std::size_t count = 0;
  for (const PartEdges& part : result.parts) count += part.edges.size();
  flatbuffers::FlatBufferBuilder builder(1024 + result.error.size() + result.parts.size() * 128 +
                                         count * sizeof(wire::Edge));
  std::vector<wire::Edge> edges;
  std::vector<flatbuffers::Offset<wire::Part>> parts;
  parts.reserve(result.parts.size());
  for (const PartEdges& part : result.parts) {
    edges.clear();
    for (const EdgePixel& edge : part.edges) {
      edges.emplace_back(edge.x, edge.y, edge.gx, edge.gy, static_cast<std::uint16_t>(edge.strength));
    }
    const auto vector = builder.CreateVectorOfStructs(edges);
    const RegionStatistics& m = part.region;
    const auto narrow = [](int value) { return static_cast<std::int16_t>(value); };
    const wire::Region region(m.m00, m.m10, m.m01, m.m20, m.m11, m.m02, narrow(m.box.x), narrow(m.box.y),
                              narrow(m.box.width), narrow(m.box.height));
    parts.push_back(wire::CreatePart(builder, &region, vector));
  }
  const auto error = builder.CreateString(result.error);
  const auto all = builder.CreateVector(parts);
  const auto body =
      wire::CreateResult(builder, result.id, static_cast<std::uint32_t>(result.busy_ms * 1e3), error, all);
  return finished(builder, wire::Body_Result, body);
}

Buffer encode(const Hello& hello) {
  flatbuffers::FlatBufferBuilder builder;
  const auto node = builder.CreateString(hello.node);
  const auto body = wire::CreateHello(builder, node, static_cast<std::uint16_t>(hello.slots),
                                      static_cast<float>(hello.pixels_per_ms));
  return finished(builder, wire::Body_Hello, body);
}

Buffer encode(const Refusal& refusal) {
  flatbuffers::FlatBufferBuilder builder;
  const auto reason = builder.CreateString(refusal.reason);
  return finished(builder, wire::Body_Refusal, wire::CreateRefusal(builder, reason));
}

Message decode(Bytes received) {
  Message message;
  const Bytes bytes = aligned(received, &message.aligned);
  constexpr std::size_t kLeast = 8;  // root offset and identifier
  require(bytes.size() >= kLeast && wire::MessageBufferHasIdentifier(bytes.data()), "this is none of cylpose");
  flatbuffers::Verifier verifier(bytes.data(), bytes.size(), 8, 1 << 20);
  require(wire::VerifyMessageBuffer(verifier), "damaged or truncated");
  const wire::Message& read = *wire::GetMessage(bytes.data());
  message.protocol = read.protocol();
  if (read.kernels() != nullptr) message.kernels = read.kernels()->str();
  if (message.protocol != kProtocol) return message;
  require(read.body() != nullptr, "it says nothing");
  switch (read.body_type()) {
    case wire::Body_Tile:
      message.body = tile_of(*read.body_as_Tile());
      return message;
    case wire::Body_Result:
      message.body = result_of(*read.body_as_Result());
      return message;
    case wire::Body_Hello:
      message.body = hello_of(*read.body_as_Hello());
      return message;
    case wire::Body_Refusal:
      require(read.body_as_Refusal()->reason() != nullptr, "a refusal gives its reason");
      message.body = Refusal{read.body_as_Refusal()->reason()->str()};
      return message;
    default:
      refuse("of an unknown kind");
  }
}

std::string version_conflict(const Message& message, const std::string& whose) {
  if (message.protocol != kProtocol) {
    return fmt::format("{} speaks protocol {} and this cylpose speaks {}; install the same version on both", whose,
                       message.protocol, kProtocol);
  }
  if (message.kernels != kernel_hash()) {
    constexpr std::size_t kShown = 12;
    return fmt::format("{} has the kernels {:.{}} and this cylpose has {:.{}}; install the same version on both", whose,
                       message.kernels, kShown, kernel_hash(), kShown);
  }
  return {};
}

void require_fits(const TileResult& result, int width, const Rows& rows, std::size_t parts) {
  constexpr int kLargestSobel = 1020;
  require(result.parts.size() == parts, "a result has as many parts as its tile");
  const std::int64_t pixels = std::int64_t{width} * (rows.end - rows.first);
  const Roi where{0, rows.first, width, rows.end - rows.first};
  for (const PartEdges& part : result.parts) {
    const RegionStatistics& region = part.region;
    require(region.m00 >= 0 && region.m00 <= pixels, "a mask is no larger than its tile");
    require(region.m00 == 0 ? region == RegionStatistics() : intersection(region.box, where) == region.box,
            "a mask lies in its tile");
    const auto bounded = [&](std::int64_t moment, std::int64_t per_pixel) {
      return moment >= 0 && moment <= region.m00 * per_pixel;
    };
    const std::int64_t x = width;
    const std::int64_t y = rows.end;
    require(bounded(region.m10, x) && bounded(region.m01, y) && bounded(region.m20, x * x) &&
                bounded(region.m11, x * y) && bounded(region.m02, y * y),
            "moments are those of pixels in the tile");
    int last_x = -1;
    int last_y = -1;
    for (const EdgePixel& edge : part.edges) {
      require(where.contains(edge.x, edge.y), "edges lie in the rows of the tile");
      require(edge.y > last_y || (edge.y == last_y && edge.x > last_x), "edges come row by row, each once");
      require(std::abs(edge.gx) <= kLargestSobel && std::abs(edge.gy) <= kLargestSobel, "gradients are Sobel's");
      last_x = edge.x;
      last_y = edge.y;
    }
  }
}

}  // namespace cylpose::cluster
