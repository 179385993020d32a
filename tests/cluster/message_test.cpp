#include "message.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cylpose/error.hpp>
#include <cylpose/opencl_devices.hpp>
#include <functional>
#include <random>

#include "host/test_images.hpp"
#include "strips.hpp"
#include "wire_generated.h"

namespace cylpose::cluster {
namespace {

using ::cylpose::testing::random_image;
using ::cylpose::testing::TestImage;
using ::testing::HasSubstr;

const std::vector<PartModel>& two_parts() {
  static const std::vector<PartModel> parts{{"red", 0.05, 0.4, 300, 60, 0.2, 0.1}, {"green", 1, 2, 80, 170, 0.3, 0.2}};
  return parts;
}

Bytes bytes_of(const Buffer& buffer) {
  return {buffer.data(), buffer.size()};
}

Tile tile_of(const TestImage& image, const Roi& roi, const Rows& rows) {
  return {7, cropped(image.view(), roi), rows, 5, 17, two_parts()};
}

TileResult found_in(const TestImage& image) {
  DetectOptions options;
  options.locate = false;
  TileResult result;
  result.id = 99;
  result.busy_ms = 1.25;
  result.parts = make_backend("serial")->detect(image.view(), image.view().bounds(), two_parts(), options).parts;
  return result;
}

std::string refusal_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    return error.what();
  }
  return "not refused";
}

TEST(Message, TilesArriveAsTheyWereSent) {
  std::mt19937 random(1);
  const TestImage image = random_image(37, 23, random, PixelFormat::kRgb8, 5);
  const Buffer sent = encode(tile_of(image, {3, 4, 21, 11}, {4, 7}));
  EXPECT_LE(sent.size(), std::size_t{21} * 11 * 3 + kTileOverhead);
  const Message message = decode(bytes_of(sent));
  EXPECT_EQ(message.protocol, kProtocol);
  EXPECT_EQ(message.kernels, kernel_hash());
  const Tile& tile = std::get<Tile>(message.body);
  EXPECT_EQ(tile.id, 7U);
  EXPECT_EQ(tile.rows, (Rows{4, 7}));
  EXPECT_EQ(tile.edge_low, 5);
  EXPECT_EQ(tile.edge_high, 17);
  ASSERT_EQ(tile.parts.size(), 2U);
  EXPECT_EQ(tile.parts[0].hue_lo_deg, 300);
  EXPECT_EQ(tile.parts[1].min_value, 0.2);
  ASSERT_EQ(tile.image.bounds(), (Roi{0, 0, 21, 11}));
  for (int y = 0; y < 11; ++y) {
    EXPECT_EQ(std::memcmp(tile.image.row(y), image.view().row(4 + y) + 9, 63), 0) << y;
  }
}

TEST(Message, ResultsArriveAsTheyWereSent) {
  std::mt19937 random(2);
  const TestImage image = random_image(60, 40, random);
  const TileResult sent = found_in(image);
  const Message message = decode(bytes_of(encode(sent)));
  const auto& read = std::get<TileResult>(message.body);
  EXPECT_EQ(read.id, 99U);
  EXPECT_NEAR(read.busy_ms, 1.25, 1e-3);
  ASSERT_EQ(read.parts.size(), 2U);
  EXPECT_GT(read.parts[0].edges.size(), 10U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.parts[i].edges, sent.parts[i].edges);
    EXPECT_EQ(read.parts[i].region, sent.parts[i].region);
  }
  EXPECT_NO_THROW(require_fits(read, 60, {0, 40}, 2));
}

TEST(Message, HellosAndRefusalsArrive) {
  const Message hello = decode(bytes_of(encode(Hello{"lab.1f", 3, 12.5})));
  EXPECT_EQ(std::get<Hello>(hello.body).node, "lab.1f");
  EXPECT_EQ(std::get<Hello>(hello.body).slots, 3);
  EXPECT_EQ(std::get<Hello>(hello.body).pixels_per_ms, 12.5);
  EXPECT_EQ(std::get<Refusal>(decode(bytes_of(encode(Refusal{"no"}))).body).reason, "no");
}

// Every prefix, and every single byte changed, is either read as something valid or refused.
TEST(Message, DamageIsRefusedOrHarmless) {
  std::mt19937 random(3);
  const TestImage image = random_image(9, 12, random);
  for (const Buffer& buffer :
       {encode(tile_of(image, {0, 0, 9, 12}, {4, 8})), encode(found_in(image)), encode(Hello{"a.b", 1, 1})}) {
    const std::vector<std::uint8_t> whole(buffer.data(), buffer.data() + buffer.size());
    std::size_t refused = 0;
    const auto read = [&](Bytes bytes) {
      try {
        static_cast<void>(decode(bytes));
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::kInput);
        ++refused;
      }
    };
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const std::vector<std::uint8_t> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      read(cut);
    }
    EXPECT_GT(refused, whole.size() * 9 / 10);
    for (std::size_t at = 0; at < whole.size(); ++at) {
      std::vector<std::uint8_t> changed = whole;
      changed[at] = static_cast<std::uint8_t>(changed[at] ^ 0xA5U);
      read(changed);
    }
  }
}

TEST(Message, SizesThatDoNotFitEachOtherAreRefused) {
  std::mt19937 random(4);
  const TestImage image = random_image(20, 20, random);
  const auto refused = [&](const std::function<void(Tile&)>& spoil) {
    Tile tile = tile_of(image, {0, 0, 20, 20}, {4, 16});
    spoil(tile);
    return refusal_of([&] { static_cast<void>(decode(bytes_of(encode(tile)))); });
  };
  EXPECT_EQ(refused([](Tile&) {}), "not refused");
  EXPECT_THAT(refused([](Tile& tile) { tile.rows = {4, 21}; }), HasSubstr("rows lie in the tile"));
  EXPECT_THAT(refused([](Tile& tile) { tile.rows = {4, 4}; }), HasSubstr("rows lie in the tile"));
  EXPECT_THAT(refused([](Tile& tile) { tile.parts.clear(); }), HasSubstr("1 to 256 parts"));
  EXPECT_THAT(refused([](Tile& tile) { tile.parts.resize(257, two_parts()[0]); }), HasSubstr("1 to 256 parts"));
  EXPECT_THAT(refused([](Tile& tile) { tile.edge_low = 18; }), HasSubstr("edge_low"));
  EXPECT_THAT(refused([](Tile& tile) { tile.parts[0].min_value = std::nan(""); }), HasSubstr("colours"));
  EXPECT_THAT(refused([](Tile& tile) { tile.image.format = static_cast<PixelFormat>(9); }), HasSubstr("format"));
}

TEST(Message, ColoursThatLieWhereDoublesCannotAreRefused) {
  const auto read = [](bool shifted) {
    flatbuffers::FlatBufferBuilder builder;
    const auto pixels = builder.CreateVector(std::vector<std::uint8_t>(9));
    if (shifted) builder.CreateVector(std::vector<std::uint32_t>());  // four bytes
    const wire::PartColor color(0, 60, 0.3, 0.2);
    builder.StartVector(sizeof(color), 1);  // as bytes, which may lie anywhere
    builder.PushBytes(reinterpret_cast<const std::uint8_t*>(&color), sizeof(color));
    const flatbuffers::Offset<flatbuffers::Vector<const wire::PartColor*>> parts(builder.EndVector(1));
    const auto gray = static_cast<std::uint8_t>(PixelFormat::kGray8);
    const auto tile = wire::CreateTile(builder, 1, gray, 3, 3, 0, 3, 5, 17, parts, pixels);
    builder.Finish(wire::CreateMessage(builder, kProtocol, 0, wire::Body_Tile, tile.Union()),
                   wire::MessageIdentifier());
    return refusal_of([&] { static_cast<void>(decode({builder.GetBufferPointer(), builder.GetSize()})); });
  };
  EXPECT_THAT((std::vector{read(false), read(true)}),
              ::testing::UnorderedElementsAre("not refused", HasSubstr("multiple of 8 bytes")));
}

TEST(Message, ResultsThatCannotBeThoseOfTheTileAreRefused) {
  std::mt19937 random(5);
  const TestImage image = random_image(60, 40, random);
  const auto refused = [&](const std::function<void(TileResult&)>& forge) {
    TileResult result = found_in(image);
    forge(result);
    return refusal_of([&] { require_fits(result, 60, {0, 40}, 2); });
  };
  EXPECT_EQ(refused([](TileResult&) {}), "not refused");
  EXPECT_THAT(refused([](TileResult& r) { r.parts.pop_back(); }), HasSubstr("as many parts"));
  EXPECT_THAT(refused([](TileResult& r) { r.parts[0].edges[0].y = 40; }), HasSubstr("in the rows"));
  EXPECT_THAT(refused([](TileResult& r) { r.parts[0].edges[0].x = 60; }), HasSubstr("in the rows"));
  EXPECT_THAT(refused([](TileResult& r) { std::swap(r.parts[0].edges[0], r.parts[0].edges[1]); }), HasSubstr("once"));
  EXPECT_THAT(refused([](TileResult& r) { r.parts[0].edges[1] = r.parts[0].edges[0]; }), HasSubstr("once"));
  EXPECT_THAT(refused([](TileResult& r) { r.parts[0].edges[0].gx = 1021; }), HasSubstr("Sobel"));
  EXPECT_THAT(refused([](TileResult& r) { r.parts[0].region.m00 = 2401; }), HasSubstr("no larger"));
  EXPECT_THAT(refused([](TileResult& r) { r.parts[0].region.m00 = -1; }), HasSubstr("no larger"));
  EXPECT_THAT(refused([](TileResult& r) { r.parts[0].region.m20 = std::int64_t{1} << 60; }), HasSubstr("moments"));
  EXPECT_THAT(refused([](TileResult& r) { r.parts[0].region.box.height = 41; }), HasSubstr("lies in its tile"));
}

TEST(Message, IsReadWhereverItLies) {
  const Buffer sent = encode(Hello{"lab.1f", 3, 12.5});
  std::vector<std::uint8_t> shifted(sent.size() + 8);
  for (std::size_t shift = 0; shift < 8; ++shift) {
    std::copy_n(sent.data(), sent.size(), shifted.data() + shift);
    const Message read = decode({shifted.data() + shift, sent.size()});
    EXPECT_EQ(std::get<Hello>(read.body).node, "lab.1f");
    EXPECT_EQ(std::get<Hello>(read.body).slots, 3);
  }
}

TEST(Message, OtherVersionsAreNamedAndNotRead) {
  flatbuffers::FlatBufferBuilder builder;
  const auto kernels = builder.CreateString("0123456789abcdef");
  builder.Finish(wire::CreateMessage(builder, kProtocol + 1, kernels), wire::MessageIdentifier());
  const Message message = decode({builder.GetBufferPointer(), builder.GetSize()});
  EXPECT_TRUE(std::holds_alternative<std::monostate>(message.body));
  EXPECT_THAT(version_conflict(message, "node a.b"), HasSubstr("node a.b speaks protocol 2"));

  Message other;
  other.protocol = kProtocol;
  other.kernels = "0123456789abcdef";
  other.body = Hello{};
  EXPECT_THAT(version_conflict(other, "node a.b"), HasSubstr("has the kernels 0123456789ab"));
  other.kernels = kernel_hash();
  EXPECT_EQ(version_conflict(other, "node a.b"), "");
}

TEST(Message, NamesThatWouldReachOtherSubjectsAreRefused) {
  for (const char* name : {"a", "a.", ".b", "a.b.c", "a.*", ">.b", "a b.c"}) {
    EXPECT_THAT(refusal_of([&] {
                  static_cast<void>(decode(bytes_of(encode(Hello{name, 1, 1}))));
                }),
                HasSubstr("two words"))
        << name;
  }
}

}  // namespace
}  // namespace cylpose::cluster
