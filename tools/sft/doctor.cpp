#include "tools/sft/doctor.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "tools/sft/dds_checks.h"
#include "tools/sft/finding.h"
#include "tools/sft/multicast_check.h"
#include "tools/sft/node_checks.h"
#include "tools/sft/system_checks.h"

namespace sft::tool {

namespace {

using Json = nlohmann::ordered_json;

const char* name_of(Health health) {
  return health == Health::ok ? "ok" : health == Health::warning ? "warning" : "error";
}

Color color_of(Health health) {
  return health == Health::ok ? Color::green : health == Health::warning ? Color::yellow : Color::red;
}

void print(const Finding& finding, Output& output) {
  const std::string health = fmt::format("{:<8}", name_of(finding.health));
  const std::string to_do = finding.to_do.empty() ? "" : ". " + finding.to_do;
  const std::string what = fmt::format("{:<11} ", finding.what);
  const std::size_t indent = health.size() + what.size();
  output.line(output.colored(health, color_of(finding.health)) + what +
              output.fitted(printable(finding.text) + to_do, indent, indent));
}

Json json_of(const Finding& finding) {
  return {{"check", finding.what},
          {"health", name_of(finding.health)},
          {"text", finding.text},
          {"to_do", finding.to_do}};
}

}  // namespace

ExitCode run(const DoctorOptions& options, const CommonOptions& common, Stop& stop, Output& output) {
  std::vector<Finding> findings{check_kernel(), check_loopback()};
  const auto append = [&](const std::vector<Finding>& more) {
    findings.insert(findings.end(), more.begin(), more.end());
  };
  const NodeFindings node = check_node(common, stop, output);
  append(node.findings);
  append(check_dds(DdsEnvironment::of_process(), node.domain));
  append(check_multicast(node.interfaces_in_use, stop));
  append({check_memlock(), check_receive_buffers(), check_open_files(), check_proc(), check_tmp(),
          check_dev_shm(), check_users(), check_clock()});
  Health worst = Health::ok;
  Json checks = Json::array();
  for (const Finding& finding : findings) {
    worst = std::max(worst, finding.health);
    checks.push_back(json_of(finding));
    const bool is_reported = !options.quiet || finding.health != Health::ok;
    if (!common.json && is_reported) print(finding, output);
  }
  if (common.json) output.document({{"health", name_of(worst)}, {"checks", std::move(checks)}});
  return static_cast<ExitCode>(worst);
}

}  // namespace sft::tool
