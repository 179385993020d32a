#include <cylpose/backend.hpp>

#include "message.hpp"
#include "refusal.hpp"

// A message is refused, or what was read of it can be worked on and written again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cylpose;
  try {
    const cluster::Message message = cluster::decode({data, size});
    if (const auto* tile = std::get_if<cluster::Tile>(&message.body)) {
      DetectOptions options;
      options.edge_low = tile->edge_low;
      options.edge_high = tile->edge_high;
      options.rows = tile->rows;
      options.locate = false;
      static const std::unique_ptr<Backend> serial = make_backend("serial");
      cluster::TileResult result;
      result.parts = serial->detect(tile->image, tile->image.bounds(), tile->parts, options).parts;
      cluster::require_fits(result, tile->image.width, tile->rows, tile->parts.size());
    } else if (const auto* result = std::get_if<cluster::TileResult>(&message.body)) {
      try {
        cluster::require_fits(*result, 16, {4, 12}, result->parts.size());
      } catch (const Error&) {
        return 0;  // read, and found impossible
      }
      const cluster::Buffer again = cluster::encode(*result);
      fuzz::require(std::holds_alternative<cluster::TileResult>(cluster::decode({again.data(), again.size()}).body),
                    "what was written can be read");
    }
  } catch (const Error& error) {
    fuzz::require(error.kind() == ErrorKind::kInput, "a refusal is an input error");
    fuzz::require(std::string_view(error.what()).starts_with("cluster message:"), "a refusal says of what");
  }
  return 0;
}
