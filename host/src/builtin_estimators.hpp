// The estimators that make_estimator knows.
#pragma once

#include <cylpose/backend.hpp>
#include <cylpose/estimator.hpp>
#include <memory>
#include <vector>

namespace cylpose {

[[nodiscard]] std::unique_ptr<Estimator> make_default_estimator(const CameraModel& camera,
                                                                const std::vector<PartModel>& parts,
                                                                std::unique_ptr<Backend> backend);

}  // namespace cylpose
