// Pixels whose neighbourhood cannot be touched: reading or writing one byte beyond them ends the process.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <cylpose/image.hpp>
#include <new>

namespace cylpose::testing {

/// A copy of an image's pixels between two unmapped pages. Only one end can lie at a page's border: the first byte
/// (kFirst) or the last one (kLast).
class GuardedPixels {
 public:
  enum class Touching { kFirst, kLast };

  GuardedPixels(const ImageView& image, Touching end) : view_(image) {
    const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    const auto row_bytes = static_cast<std::size_t>(image.width * bytes_per_pixel(image.format));
    const std::size_t bytes = static_cast<std::size_t>(image.height - 1) * static_cast<std::size_t>(image.stride) +
                              row_bytes;  // the last row's padding is not there
    const std::size_t inner = (bytes + page - 1) / page * page;
    size_ = inner + 2 * page;
    void* mapped = ::mmap(nullptr, size_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapped == MAP_FAILED) throw std::bad_alloc();
    base_ = static_cast<std::uint8_t*>(mapped);
    if (::mprotect(base_ + page, inner, PROT_READ | PROT_WRITE) != 0) throw std::bad_alloc();
    std::uint8_t* first = base_ + page + (end == Touching::kFirst ? 0 : inner - bytes);
    std::memcpy(first, image.data, bytes);
    if (::mprotect(base_ + page, inner, PROT_READ) != 0) throw std::bad_alloc();
    view_.data = first;
  }
  ~GuardedPixels() { ::munmap(base_, size_); }
  GuardedPixels(const GuardedPixels&) = delete;
  GuardedPixels& operator=(const GuardedPixels&) = delete;

  [[nodiscard]] const ImageView& view() const { return view_; }

 private:
  ImageView view_;
  std::uint8_t* base_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace cylpose::testing
