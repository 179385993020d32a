#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cylpose/backend.hpp>
#include <cylpose/error.hpp>
#include <string>
#include <thread>

namespace cylpose {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class NamedBackend final : public Backend {
 public:
  explicit NamedBackend(std::string name) : name_(std::move(name)) {}
  [[nodiscard]] std::string_view name() const override { return name_; }
  [[nodiscard]] EdgeField detect(const ImageView&, const Roi&, std::span<const PartModel>,
                                 const DetectOptions&) override {
    return {};
  }

 private:
  std::string name_;
};

BackendInfo info_named(const std::string& name) {
  return {name, "for a test", [name] { return std::make_unique<NamedBackend>(name); }};
}

template <typename Function>
std::string error_of(Function function) {
  try {
    function();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    return error.what();
  }
  return "no error";
}

TEST(Backends, EveryBackendThatIsListedCanBeMadeAndBearsItsName) {
  const std::vector<BackendInfo> all = backends();
  ASSERT_GE(all.size(), 2U);
  EXPECT_EQ(all[0].name, "serial");
  EXPECT_EQ(all[1].name, "opencv");
  for (const BackendInfo& info : all) {
    EXPECT_FALSE(info.description.empty());
    EXPECT_EQ(make_backend(info.name)->name(), info.name);
  }
}

TEST(Backends, ARegisteredBackendIsKnownAndItsNameTaken) {
  register_backend(info_named("test_registered"));
  EXPECT_EQ(make_backend("test_registered")->name(), "test_registered");
  EXPECT_EQ(backends().back().name, "test_registered");
  EXPECT_THAT(error_of([] { register_backend(info_named("test_registered")); }), HasSubstr("'test_registered'"));
  EXPECT_THAT(error_of([] { register_backend(info_named("serial")); }), HasSubstr("'serial'"));
}

TEST(Backends, AnUnknownNameIsAnsweredWithTheKnownOnes) {
  EXPECT_THAT(error_of([] { static_cast<void>(make_backend("quantum")); }),
              AllOf(HasSubstr("'quantum'"), HasSubstr("serial"), HasSubstr("opencv")));
}

TEST(Backends, RegistrationFromSeveralThreadsLosesNothing) {
  const std::size_t before = backends().size();
  const auto register_many = [](const std::string& prefix) {
    for (int i = 0; i < 50; ++i) {
      register_backend(info_named(prefix + std::to_string(i)));
      static_cast<void>(make_backend("serial"));
    }
  };
  std::thread other(register_many, "test_other_");
  register_many("test_this_");
  other.join();
  EXPECT_EQ(backends().size(), before + 100);
}

TEST(Backends, WithoutADriverTheWholeDetectionIsLeftToTheEnd) {
  const auto serial = make_backend("serial");
  const std::vector<std::uint8_t> pixels(std::size_t{3} * 8 * 6, 200);
  const ImageView image{pixels.data(), 8, 6, 24, PixelFormat::kBgr8};
  const PartModel part{"any", 1, 1, 0, 360, 0, 0.1};
  std::shared_ptr<DetectionEnd> end;
  serial->detect_async({image, image.bounds(), {&part, 1}, {}}, [&](auto ended) { end = std::move(ended); });
  ASSERT_NE(end, nullptr);
  EXPECT_EQ(end->field().parts.at(0).region, serial->detect(image, image.bounds(), {&part, 1}, {}).parts.at(0).region);
  serial->detect_async({{}, {}, {&part, 1}, {}}, [&](auto ended) { end = std::move(ended); });
  EXPECT_THAT(error_of([&] { static_cast<void>(end->field()); }), HasSubstr("empty"));
}

TEST(DetectOptions, DefaultsAreValid) {
  std::string why;
  EXPECT_TRUE(DetectOptions{}.is_valid(&why)) << why;
  EXPECT_TRUE(DetectOptions{}.is_valid(nullptr));
}

TEST(DetectOptions, ThresholdsOutsideTheirRangesAreRefusedByNameAndValue) {
  const auto reason = [](int low, int high) {
    DetectOptions options;
    options.edge_low = low;
    options.edge_high = high;
    std::string why;
    EXPECT_FALSE(options.is_valid(&why));
    EXPECT_FALSE(options.is_valid(nullptr));
    return why;
  };
  EXPECT_THAT(reason(0, 16), AllOf(HasSubstr("edge_low"), HasSubstr("0")));
  EXPECT_THAT(reason(17, 16), AllOf(HasSubstr("edge_low"), HasSubstr("17")));
  EXPECT_THAT(reason(6, 256), AllOf(HasSubstr("edge_high"), HasSubstr("256")));
  EXPECT_THAT(reason(-1, -1), AllOf(HasSubstr("edge_high"), HasSubstr("-1")));
  DetectOptions options;
  options.edge_low = options.edge_high = 255;
  EXPECT_TRUE(options.is_valid(nullptr));
}

TEST(UsableSearch, CutsToTheImageAndRefusesBadInput) {
  const std::uint8_t pixel[3] = {};
  const ImageView image{pixel, 1, 1, 3, PixelFormat::kBgr8};
  EXPECT_EQ(usable_search(image, {-5, -5, 20, 20}, {}), (Roi{0, 0, 1, 1}));
  EXPECT_TRUE(usable_search(image, {1, 0, 20, 20}, {}).empty());
  DetectOptions options;
  options.edge_low = 0;
  EXPECT_THAT(error_of([&] { static_cast<void>(usable_search(image, image.bounds(), options)); }),
              HasSubstr("edge_low"));
  EXPECT_THAT(error_of([&] { static_cast<void>(usable_search({}, {}, {})); }), HasSubstr("empty"));
}

}  // namespace
}  // namespace cylpose
