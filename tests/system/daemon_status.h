// The status that the daemon of shared memory has written last, or a discarded value if no daemon runs.
#pragma once

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/isolated_host.h"

namespace sft::test {

inline nlohmann::json daemon_status() {
  const std::string command = program_directory() + "/sftd status --json";
  const std::unique_ptr<FILE, int (*)(FILE*)> output(popen(command.c_str(), "r"), &pclose);
  return nlohmann::json::parse(output.get(), nullptr, false);
}

}  // namespace sft::test
