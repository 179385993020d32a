#include "contender.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cylpose/error.hpp>
#include <functional>
#include <utility>

namespace cylpose::bench {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// The serial backend with a fault.
class Faulty final : public Backend {
 public:
  Faulty(std::string name, std::function<void(EdgeField&)> fault) : name_(std::move(name)), fault_(std::move(fault)) {}

  [[nodiscard]] std::string_view name() const override { return name_; }
  [[nodiscard]] EdgeField detect(const ImageView& image, const Roi& search, std::span<const PartModel> parts,
                                 const DetectOptions& options) override {
    EdgeField field = serial_->detect(image, search, parts, options);
    fault_(field);
    return field;
  }

 private:
  std::string name_;
  std::function<void(EdgeField&)> fault_;
  std::unique_ptr<Backend> serial_ = make_backend("serial");
};

Contender& contender(const std::string& name, std::function<void(EdgeField&)> fault) {
  register_backend({name, "for this test", [=] { return std::make_unique<Faulty>(name, fault); }});
  return Contender::named(name);
}

const FrameSize& smallest() {
  return kFrameSizes[0];
}

TEST(Contender, TheRightAnswerIsAccepted) {
  Contender& right = contender("right", [](EdgeField&) {});
  EXPECT_NO_THROW(right.require_agreement(full_scene(smallest()), "full"));
  EXPECT_NO_THROW(right.require_agreement(roi_scene(smallest()), "roi"));
}

TEST(Contender, AWrongAnswerIsRefusedEveryTime) {
  const BenchScene scene = roi_scene(smallest());
  Contender& shifted = contender("shifted", [](EdgeField& field) {
    for (EdgePixel& edge : field.parts[0].edges) ++edge.x;
  });
  Contender& blind = contender("blind", [](EdgeField& field) { field.parts[0].edges.clear(); });
  Contender& careless = contender("careless", [](EdgeField& field) {
    if (field.parts[0].mask.pixels.empty()) field.parts[0].edges.pop_back();
  });
  for (Contender* wrong : {&shifted, &blind, &careless}) {
    for (int time = 0; time < 2; ++time) {
      EXPECT_THAT([&] { wrong->require_agreement(scene, "roi"); },
                  ThrowsMessage<Error>(HasSubstr("not the answer of serial")));
    }
  }
}

TEST(Contender, NothingToFindIsNothingToCompare) {
  Contender& right = contender("right on nothing", [](EdgeField&) {});
  EXPECT_THAT([&] { right.require_agreement(empty_scene(), "empty"); },
              ThrowsMessage<Error>(HasSubstr("nothing to compare")));
}

TEST(Contender, TheBackendMustBeTheOneAskedFor) {
  register_backend({"wanted", "for this test", [] { return make_backend("serial"); }});
  EXPECT_THAT([] { Contender::named("wanted"); }, ThrowsMessage<Error>(HasSubstr("it is 'serial' that was made")));
}

TEST(Scenes, TheRegionOfTheFrameBeforeHoldsThePart) {
  for (const FrameSize& size : {kFrameSizes[0], kFrameSizes[1]}) {
    const BenchScene full = full_scene(size);
    const BenchScene roi = roi_scene(size);
    EXPECT_EQ(full.search, (Roi{0, 0, size.width, size.height}));
    EXPECT_LT(roi.search.width * roi.search.height, size.width * size.height / 2);
    const auto area = [](const BenchScene& scene) {
      return make_backend("serial")
          ->detect(scene.image(), scene.search, scene.parts, detect_options(scene))
          .parts.at(0)
          .region.m00;
    };
    EXPECT_EQ(area(roi), area(full));
    // The same share of the picture at every size.
    const double scale = full.camera.fx / 1215;
    EXPECT_NEAR(static_cast<double>(area(full)) / (scale * scale), 56000, 12000);
  }
}

}  // namespace
}  // namespace cylpose::bench
