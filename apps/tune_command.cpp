#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <cylpose/backend.hpp>
#include <cylpose/error.hpp>
#include <cylpose/image_cv.hpp>
#include <cylpose/tune.hpp>
#include <filesystem>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "commands.hpp"
#include "help_text.hpp"

namespace cylpose::apps {
namespace {

struct TuneArguments {
  std::string image;
  std::vector<int> rect;
  std::string name = "part";
  double radius_m = 0;
  double height_m = 0;
  std::string output;
};

cv::Mat read_color_image(const std::string& path) {
  if (!std::filesystem::exists(path)) throw Error(ErrorKind::kInput, path + ": no such file; is the path right?");
  cv::Mat image = cv::imread(path, cv::IMREAD_COLOR);
  if (image.empty()) {
    throw Error(ErrorKind::kInput, path + ": cannot be read as an image; is it a picture file?");
  }
  return image;
}

void write_picture(const std::string& path, const cv::Mat& picture) {
  bool written = false;
  try {
    written = cv::imwrite(path, picture);
  } catch (const cv::Exception&) {  // no encoder for the extension
    throw Error(ErrorKind::kOutput, path + ": no image format has this extension; use .png or .jpg");
  }
  if (!written) throw Error(ErrorKind::kOutput, path + ": cannot be written; does the folder exist?");
}

double percent_set(const Mask& mask, const Roi& roi) {
  std::int64_t set = 0;
  for (int y = roi.y; y < roi.bottom(); ++y) {
    for (int x = roi.x; x < roi.right(); ++x) {
      set += mask.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(mask.roi.width) +
                         static_cast<std::size_t>(x)] != 0;
    }
  }
  return 100.0 * static_cast<double>(set) / (static_cast<double>(roi.width) * roi.height);
}

void tune(const TuneArguments& arguments) {
  const cv::Mat pixels = read_color_image(arguments.image);
  const ImageView image = view_of(pixels);
  const Roi sample{arguments.rect[0], arguments.rect[1], arguments.rect[2], arguments.rect[3]};
  const ColorSuggestion color = suggest_color(image, sample);
  const PartModel part{arguments.name,   arguments.radius_m,   arguments.height_m, color.hue_lo_deg,
                       color.hue_hi_deg, color.min_saturation, color.min_value};

  DetectOptions options;
  options.with_mask = true;
  const EdgeField field = make_backend("serial")->detect(image, image.bounds(), {&part, 1}, options);
  const Mask& mask = field.parts.front().mask;
  if (!arguments.output.empty()) write_picture(arguments.output, mask_picture(image, mask, sample));

  // The entry alone goes to stdout, so that it can be sent to a file.
  fmt::print("{}", parts_file_text(part));
  fmt::print(stderr, "The mask holds {:.1f} % of the sample and {:.1f} % of the image{}.\n", percent_set(mask, sample),
             percent_set(mask, image.bounds()),
             arguments.output.empty() ? "; --output mask.png shows it" : ", see " + arguments.output);
  if (part.radius_m == 0 || part.height_m == 0) {
    fmt::print(stderr, "Fill in the sizes before use, or give --radius-m and --height-m.\n");
  }
}

}  // namespace

void add_tune_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("tune", "Suggest a part's hue range and floors from a sample of it; prints a parts file.");
  set_examples(*command, {"cylpose tune photo.png --rect 660,300,40,80 --name link --radius-m 0.05 --height-m 0.4 "
                          "--output mask.png > parts.yaml"});
  const auto arguments = std::make_shared<TuneArguments>();
  command->add_option("IMAGE", arguments->image, "Image that shows the part")->required()->type_name("FILE");
  command->add_option("--rect", arguments->rect, "Sample on the part: left, top, width, height in pixels")
      ->delimiter(',')
      ->expected(4)
      ->required()
      ->type_name("X,Y,W,H");
  command->add_option("--name", arguments->name, fmt::format("Name of the part (default: {})", arguments->name))
      ->type_name("NAME");
  command
      ->add_option("--radius-m", arguments->radius_m,
                   "Its radius in metres, 0.0001 to 1000 (default: 0, to be filled in)")
      ->check(CLI::Range(1e-4, 1e3).description(""))
      ->type_name("METRES");
  command
      ->add_option("--height-m", arguments->height_m,
                   "Its height in metres, 0.0001 to 1000 (default: 0, to be filled in)")
      ->check(CLI::Range(1e-4, 1e3).description(""))
      ->type_name("METRES");
  command
      ->add_option("-o,--output", arguments->output,
                   "Write a picture: the image with the sample, and beside it the image darkened outside the mask")
      ->type_name("FILE");
  command->callback([arguments] { tune(*arguments); });
}

}  // namespace cylpose::apps
