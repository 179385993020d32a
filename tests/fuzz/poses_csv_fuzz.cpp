#include "text_readers.hpp"
#include "valid_rows.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cylpose;
  fuzz::read_or_refuse([&] { fuzz::require_valid(poses_from_csv("file", fuzz::text_of(data, size))); });
  return 0;
}
