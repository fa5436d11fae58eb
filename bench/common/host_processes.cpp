#include "bench/common/host_processes.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <numeric>
#include <string>
#include <utility>

#include "bench/common/process.h"
#include "core/platform/text_of.h"
#include "tools/hosts/interface_counters.h"

namespace sft::bench {

namespace {

std::string text_of(pid_t process, const char* file) {
  return core::text_of(fmt::format("/proc/{}/{}", process, file));
}

/// Returns a number of bytes that the file /proc/PID/FILE gives in kB. `key` is the beginning of its line.
double bytes_of(pid_t process, const char* file, const std::string& key) {
  const std::string text = text_of(process, file);
  const std::size_t at = text.find(key);
  return at == std::string::npos ? 0 : 1024 * std::stod(text.substr(at + key.size()));
}

}  // namespace

HostProcesses::HostProcesses(std::size_t hosts)
    : HostProcesses(std::make_shared<hosts::EmulatedNetwork>(make_hosts(hosts + 1, Trains::cut)), hosts) {}

HostProcesses::HostProcesses(std::shared_ptr<const hosts::EmulatedNetwork> network, std::size_t hosts)
    : hosts_(hosts + 1), network_(std::move(network)) {}

HostProcesses::~HostProcesses() {
  for (const Member& member : members_) kill(member.process, SIGKILL);
  for (const Member& member : members_) succeeds(member.process);
}

pid_t HostProcesses::start(std::size_t host, const std::function<int()>& run) {
  members_.push_back({start_process([&] { return network_->host(host).enter() ? run() : 1; }), host});
  return members_.back().process;
}

bool HostProcesses::first_succeeds() {
  const bool succeeded = succeeds(members_.front().process);
  members_.erase(members_.begin());
  return succeeded;
}

double HostProcesses::cpu_s() const {
  return std::accumulate(members_.begin(), members_.end(), 0.,
                         [](double sum, const Member& member) { return sum + bench::cpu_s(member.process); });
}

double HostProcesses::resident_bytes() const { return sum_of_bytes("status", "VmRSS:"); }

double HostProcesses::anonymous_bytes() const { return sum_of_bytes("smaps_rollup", "\nAnonymous:"); }

double HostProcesses::sum_of_bytes(const char* file, const char* key) const {
  return std::accumulate(members_.begin(), members_.end(), 0., [=](double sum, const Member& member) {
    return sum + bytes_of(member.process, file, key);
  });
}

LinkBytes HostProcesses::link_bytes() const {
  LinkBytes sum;
  for (std::size_t host = 0; host < hosts_; ++host) {
    const LinkBytes bytes = link_bytes(host);
    sum.received += bytes.received;
    sum.sent += bytes.sent;
  }
  return sum;
}

LinkBytes HostProcesses::link_bytes(std::size_t host) const {
  const auto member = std::ranges::find(members_, host, &Member::host);
  const auto bytes = hosts::parse_interface_bytes(text_of(member->process, "net/dev"), hosts::host_interface)
                         .value_or(hosts::InterfaceBytes{});
  return {static_cast<std::int64_t>(bytes.received), static_cast<std::int64_t>(bytes.sent)};
}

}  // namespace sft::bench
