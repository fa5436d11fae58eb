// The contenders for groups of processes, with default settings, and their messages.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/message_set.h"

namespace sft::bench {

struct Member {
  const char* name;
  Contender open;
};
inline constexpr Member sft_member{"SFT", sft_usual_peer};
inline constexpr Member cyclone_member{"Cyclone DDS", cyclone_usual_peer};

/// A function that returns the fields that the reader with this number requests.
using Fields = std::function<std::string(std::size_t)>;

/// Returns the topic of clouds with this number of data bytes, best effort.
Topic cloud_topic(std::size_t data_bytes, const std::string& name = "points");
}  // namespace sft::bench
