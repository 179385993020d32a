#include "models.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <cylpose/error.hpp>
#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "bindings.hpp"
#include "fields.hpp"
#include "text.hpp"

namespace cylpose::python {
namespace {

constexpr const char* kNumber = "a number";

template <typename T>
using Words = std::map<std::string, T>;

// As in camera files.
const Words<DistortionModel>& distortion_models() {
  static const Words<DistortionModel> words = {{"none", DistortionModel::kNone},
                                               {"plumb_bob", DistortionModel::kPlumbBob},
                                               {"rational_polynomial", DistortionModel::kRational},
                                               {"equidistant", DistortionModel::kFisheye}};
  return words;
}

const Words<Transfer>& transfers() {
  static const Words<Transfer> words = {{"srgb", Transfer::kSrgb}, {"linear", Transfer::kLinear}};
  return words;
}

template <typename T>
T value_of(const Words<T>& words, const py::handle& object, const char* name) {
  const auto word = field<std::string>(object, name, "text");
  const auto found = words.find(word);
  if (found != words.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [text, value] : words) known.push_back(text);
  throw Error(ErrorKind::kInput,
              fmt::format("camera: unknown {} '{}'; write one of: {}", name, word, fmt::join(known, ", ")));
}

template <typename T>
std::string word_of(const Words<T>& words, T value) {
  for (const auto& [text, known] : words) {
    if (known == value) return text;
  }
  return {};
}

// In the order of the dataclass's fields.
py::tuple tuple_of(const CameraModel& camera) {
  return py::make_tuple(camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy,
                        word_of(distortion_models(), camera.distortion_model), py::tuple(py::cast(camera.distortion)),
                        word_of(transfers(), camera.transfer));
}

py::tuple tuple_of(const PartModel& part) {
  return py::make_tuple(python_text(part.name), part.radius_m, part.height_m,
                        py::make_tuple(part.hue_lo_deg, part.hue_hi_deg), part.min_saturation, part.min_value);
}

}  // namespace

CameraModel camera_of(const py::object& camera) {
  CameraModel model;
  model.width = field<int>(camera, "width", "a whole number");
  model.height = field<int>(camera, "height", "a whole number");
  model.fx = field<double>(camera, "fx", kNumber);
  model.fy = field<double>(camera, "fy", kNumber);
  model.cx = field<double>(camera, "cx", kNumber);
  model.cy = field<double>(camera, "cy", kNumber);
  model.distortion_model = value_of(distortion_models(), camera, "distortion_model");
  model.distortion = field<std::vector<double>>(camera, "distortion", "a sequence of numbers");
  model.transfer = value_of(transfers(), camera, "transfer");
  return model;
}

std::vector<PartModel> parts_of(const py::iterable& parts) {
  std::vector<PartModel> models;
  for (const py::handle part : parts) {
    const auto [lo, hi] = field<std::pair<double, double>>(part, "hue_deg", "two numbers, from and to");
    models.push_back({native_text(field<py::str>(part, "name", "text")), field<double>(part, "radius_m", kNumber),
                      field<double>(part, "height_m", kNumber), lo, hi, field<double>(part, "min_saturation", kNumber),
                      field<double>(part, "min_value", kNumber)});
  }
  return models;
}

void bind_models(py::module_& module) {
  module.def(
      "load_camera",
      [](const std::filesystem::path& path) { return tuple_of(without_gil([&] { return load_camera(path); })); },
      py::arg("path"));
  module.def(
      "load_parts",
      [](const std::filesystem::path& path) {
        py::list parts;
        for (const PartModel& part : without_gil([&] { return load_parts(path); })) parts.append(tuple_of(part));
        return parts;
      },
      py::arg("path"));
}

}  // namespace cylpose::python
