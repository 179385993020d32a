// The readers of files on text that is in memory already: what follows the reading in load_camera, load_parts,
// load_poses and load_truth. `name` stands for the file in messages. All throw Error(kInput), and nothing else whatever
// the text is.
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/extrinsics.hpp>
#include <cylpose/part.hpp>
#include <cylpose/pose_io.hpp>
#include <iosfwd>
#include <string>
#include <vector>

namespace cylpose {

[[nodiscard]] CameraModel camera_from_yaml(const std::string& name, std::string text);
[[nodiscard]] std::vector<PartModel> parts_from_yaml(const std::string& name, std::string text);
[[nodiscard]] Extrinsics extrinsics_from_yaml(const std::string& name, std::string text);
[[nodiscard]] std::vector<PoseRow> poses_from_csv(std::string name, std::string text);
[[nodiscard]] std::vector<PoseRow> poses_from_jsonl(const std::string& name, std::istream& lines);
[[nodiscard]] std::vector<TruthRow> truth_from_csv(std::string name, std::string text);

}  // namespace cylpose
