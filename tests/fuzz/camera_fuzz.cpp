#include "refusal.hpp"
#include "text_readers.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cylpose;
  fuzz::read_or_refuse([&] {
    const CameraModel camera = camera_from_yaml("file", fuzz::text_of(data, size));
    fuzz::require(camera.is_valid(nullptr), "what is read is a valid camera");
  });
  return 0;
}
