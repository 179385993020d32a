// The definition of correct: plain scalar C++, integers only, one stage after the other. Every other backend is
// measured against it. What a mask or edge pixel is depends on the image up to 4 pixels around it: erosion 1,
// dilation 1, and then 2, either for the band (mask) or for Sobel and suppression (response); so tiles need a halo
// of 4.
#include <cylpose/gate.hpp>
#include <cylpose/locate.hpp>
#include <utility>

#include "builtin_backends.hpp"
#include "channels.hpp"
#include "serial/edges.hpp"
#include "serial/morphology.hpp"
#include "serial/statistics.hpp"
#include "stage_clock.hpp"

namespace cylpose {
namespace {

using Masks = std::vector<Mask>;

// One read of the pixels for all parts: a row stays in the cache while every gate looks at it.
Masks gated(const ImageView& image, const Roi& search, std::span<const ColorGate> gates) {
  const auto width = static_cast<std::size_t>(search.width);
  Masks masks(gates.size(), Mask{search, std::vector<std::uint8_t>(width * static_cast<std::size_t>(search.height))});
  const Channels channel = channels_of(image.format);
  const bool gray = image.format == PixelFormat::kGray8;
  for (int y = 0; y < search.height; ++y) {
    const std::uint8_t* row = image.row(search.y + y) + static_cast<std::ptrdiff_t>(search.x) * channel.step;
    for (std::size_t part = 0; part < gates.size(); ++part) {
      const ColorGate gate = gates[part];
      std::uint8_t* out = masks[part].pixels.data() + static_cast<std::size_t>(y) * width;
      const std::uint8_t* pixel = row;
      for (std::size_t x = 0; x < width; ++x, pixel += channel.step) {
        const bool inside = gray ? passes_gray(gate, *pixel)
                                 : passes(gate, pixel[channel.red], pixel[channel.green], pixel[channel.blue]);
        out[x] = inside ? 255 : 0;
      }
    }
  }
  return masks;
}

class SerialBackend final : public Backend {
 public:
  [[nodiscard]] std::string_view name() const override { return "serial"; }

  [[nodiscard]] EdgeField detect(const ImageView& image, const Roi& search, std::span<const PartModel> parts,
                                 const DetectOptions& options) override {
    EdgeField field;
    field.searched = usable_search(image, search, options);
    field.parts.resize(parts.size());
    std::vector<ColorGate> gates;
    gates.reserve(parts.size());
    for (const PartModel& part : parts) gates.push_back(make_gate(part));

    StageClock clock;
    Masks masks = gated(image, field.searched, gates);
    clock.lap("gate");

    for (Mask& mask : masks) mask = serial::dilated(serial::eroded(mask));
    clock.lap("morphology");

    for (std::size_t i = 0; i < masks.size(); ++i) field.parts[i].region = serial::statistics_of(masks[i]);
    clock.lap("statistics");

    for (std::size_t i = 0; i < masks.size(); ++i) {
      PartEdges& part = field.parts[i];
      if (part.region.m00 == 0) continue;
      const Mask band = serial::border_band(masks[i], part.region.box);
      part.edges = serial::find_edges(image, field.searched, gates[i], band, options);
      serial::keep_rows(options.rows, masks[i], part);
    }
    clock.lap("edges");

    for (std::size_t i = 0; options.locate && i < masks.size(); ++i) {
      locate_edges(image, field.searched, gates[i], options.transfer, field.parts[i].edges);
    }
    clock.lap("locate");

    if (options.with_mask) {
      for (std::size_t i = 0; i < masks.size(); ++i) field.parts[i].mask = std::move(masks[i]);
    }
    field.times = clock.times();
    return field;
  }
};

}  // namespace

std::unique_ptr<Backend> make_serial_backend() {
  return std::make_unique<SerialBackend>();
}

}  // namespace cylpose
