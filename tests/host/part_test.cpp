#include <gmock/gmock.h>

#include <cylpose/error.hpp>
#include <cylpose/part.hpp>
#include <limits>

#include "temp_dir.hpp"

namespace cylpose {
namespace {

using testing::HasSubstr;

constexpr const char* kParts = R"(parts:
  - name: candle
    radius_m: 0.0395
    height_m: 0.27
    hue_deg: [345, 15]
    min_saturation: 0.4
    min_value: 0.2
  - {name: link, radius_m: 0.05, height_m: 0.4, hue_deg: [90, 150], min_saturation: 0.3, min_value: 0.1}
)";

PartModel green_part() {
  return {"green", 0.05, 0.4, 90, 150, 0.3, 0.1};
}

class PartFile : public testing::Test {
 protected:
  std::string refusal(const std::string& text) {
    try {
      (void)load_parts(folder_.write("part.yaml", text));
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
      EXPECT_THAT(error.what(), HasSubstr("part.yaml"));
      return error.what();
    }
    ADD_FAILURE() << "was accepted:\n" << text;
    return {};
  }

  static std::string changed(const std::string& from, const std::string& to) {
    std::string text = kParts;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }

  TempDir folder_;
};

TEST_F(PartFile, ReadsAllParts) {
  const std::vector<PartModel> parts = load_parts(folder_.write("part.yaml", kParts));
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].name, "candle");
  EXPECT_EQ(parts[0].radius_m, 0.0395);
  EXPECT_EQ(parts[0].height_m, 0.27);
  EXPECT_EQ(parts[0].hue_lo_deg, 345);
  EXPECT_EQ(parts[0].hue_hi_deg, 15);
  EXPECT_EQ(parts[0].min_saturation, 0.4);
  EXPECT_EQ(parts[0].min_value, 0.2);
  EXPECT_EQ(parts[1].name, "link");
}

TEST_F(PartFile, WhatIsSavedLoadsTheSame) {
  PartModel odd = green_part();
  odd.name = "it's: #1 \xC3\xA4 - [x]";
  odd.radius_m = 1.0 / 3;
  const std::filesystem::path path = folder_.path() / "saved.yaml";
  save_parts({green_part(), odd}, path);
  const std::vector<PartModel> loaded = load_parts(path);
  ASSERT_EQ(loaded.size(), 2U);
  EXPECT_EQ(loaded[0].name, "green");
  EXPECT_EQ(loaded[0].hue_hi_deg, 150);
  EXPECT_EQ(loaded[1].name, odd.name);
  EXPECT_EQ(loaded[1].radius_m, odd.radius_m);
  EXPECT_EQ(loaded[1].min_value, odd.min_value);
}

TEST_F(PartFile, SavingWhereNothingCanBeWrittenNamesThePath) {
  try {
    save_parts({green_part()}, folder_.path());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kOutput);
    EXPECT_THAT(error.what(), HasSubstr(folder_.path().string()));
  }
}

TEST_F(PartFile, RefusalsNameLineValueAndRemedy) {
  EXPECT_THAT(refusal(changed("0.0395", "-0.0395")),
              HasSubstr("part 'candle': radius_m is -0.0395; give metres above 0"));
  EXPECT_THAT(refusal(changed("0.0395", "nan")),
              HasSubstr("part.yaml:3: parts[0].radius_m: 'nan' is no finite number"));
  EXPECT_THAT(refusal(changed("0.27", "0")), HasSubstr("height_m is 0"));
  EXPECT_THAT(refusal(changed("[345, 15]", "[20, 20]")), HasSubstr("[20, 20] is a range of no width; widen it"));
  EXPECT_THAT(refusal(changed("[345, 15]", "[360, 0]")), HasSubstr("no width"));
  EXPECT_THAT(refusal(changed("[345, 15]", "[-15, 15]")), HasSubstr("a range over red wraps like [345, 15]"));
  EXPECT_THAT(refusal(changed("[345, 15]", "[345]")), HasSubstr("has 1 values; write [lo, hi]"));
  EXPECT_THAT(refusal(changed("[345, 15]", "red")), HasSubstr("parts[0].hue_deg: expected a list"));
  EXPECT_THAT(refusal(changed("min_saturation: 0.4", "min_saturation: 40")),
              HasSubstr("min_saturation is 40; give 0..1"));
  EXPECT_THAT(refusal(changed("min_value: 0.2", "min_value: -1")), HasSubstr("min_value is -1"));
  EXPECT_THAT(refusal(changed("radius_m: 0.0395", "radius: 0.0395")),
              HasSubstr("unknown key 'radius'; known keys: name, radius_m, height_m"));
  EXPECT_THAT(refusal(changed("    min_value: 0.2\n", "")), HasSubstr("the key 'min_value' is missing"));
  EXPECT_THAT(refusal(changed("min_value: 0.2", "min_value: 0.2\n    min_value: 0.3")), HasSubstr("given twice"));
  EXPECT_THAT(refusal(changed("link", "candle")), HasSubstr("a part named 'candle' is there already"));
  EXPECT_THAT(refusal(changed("name: candle", "name: \"\"")), HasSubstr("give the part a name"));
  EXPECT_THAT(refusal(changed("name: candle", "name: 'a,b'")), HasSubstr("comma"));
  EXPECT_THAT(refusal(changed("name: candle", "name: ../up")), HasSubstr("slash"));
}

TEST_F(PartFile, RefusesWhatIsNoPartList) {
  EXPECT_THAT(refusal(""), HasSubstr("is empty"));
  EXPECT_THAT(refusal("parts:"), HasSubstr("expected a list"));
  EXPECT_THAT(refusal("parts: []"), HasSubstr("at least one part"));
  EXPECT_THAT(refusal("part: []"), HasSubstr("known keys: parts"));
  EXPECT_THAT(refusal("parts: [candle]"), HasSubstr("expected `key: value`"));
  EXPECT_THAT(refusal("parts:\n  - {name: x"), HasSubstr("no valid YAML"));
}

TEST(Part, RefusesNanInEveryField) {
  EXPECT_TRUE(green_part().is_valid(nullptr));
  double PartModel::*const fields[] = {&PartModel::radius_m,   &PartModel::height_m,       &PartModel::hue_lo_deg,
                                       &PartModel::hue_hi_deg, &PartModel::min_saturation, &PartModel::min_value};
  for (const auto field : fields) {
    PartModel part = green_part();
    part.*field = std::numeric_limits<double>::quiet_NaN();
    std::string why;
    EXPECT_FALSE(part.is_valid(&why));
    EXPECT_THAT(why, HasSubstr("is nan"));
  }
}

TEST(Part, TheWholeHueCircleIsARange) {
  PartModel part = green_part();
  part.hue_lo_deg = 0;
  part.hue_hi_deg = 360;
  EXPECT_TRUE(part.is_valid(nullptr));
}

}  // namespace
}  // namespace cylpose
