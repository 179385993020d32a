// What the cluster's commands share.
#pragma once

#include <cylpose/cluster/connection.hpp>
#include <string>

#include "cluster_backend.hpp"

namespace cylpose::apps {

/// nats://127.0.0.1:4222 where no server is named.
[[nodiscard]] cluster::ConnectionOptions connection_options(const ClusterArguments& arguments);

/// A line on standard error, from any thread.
void tell_user(const std::string& what);

}  // namespace cylpose::apps
