#include <algorithm>

#include "refusal.hpp"
#include "text_readers.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cylpose;
  fuzz::read_or_refuse([&] {
    const std::vector<PartModel> parts = parts_from_yaml("file", fuzz::text_of(data, size));
    fuzz::require(!parts.empty(), "there is a part");
    fuzz::require(std::all_of(parts.begin(), parts.end(), [](const PartModel& part) { return part.is_valid(nullptr); }),
                  "every part is valid");
  });
  return 0;
}
