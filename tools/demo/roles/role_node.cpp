#include "tools/demo/roles/role_node.h"

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tools/hosts/own_host.h"

namespace sft::demo {

namespace {

/// Returns the path of the sftd beside the program; empty if SFT_DAEMON is set, or if there is none. The
/// library could not find that sftd: a process with mounts of its own in a chroot has lost the directory of
/// its program.
std::string daemon_beside_program() {
  const std::filesystem::path daemon = hosts::program_directory() / "sftd";
  std::error_code error;
  const bool is_chosen = std::getenv("SFT_DAEMON") != nullptr;
  return is_chosen || !std::filesystem::exists(daemon, error) ? "" : daemon.string();
}

}  // namespace

Result<std::unique_ptr<RoleNode>> RoleNode::open(const NodePlan& plan) {
  std::unique_ptr<RoleNode> role(new RoleNode);
  if (plan.interface) {
    Result<std::unique_ptr<TrafficMeter>> meter = TrafficMeter::open(*plan.interface);
    if (!meter) return tl::unexpected(meter.error());
    role->meter_ = std::move(*meter);
  }
  Result<Node> node = Node::open({
      .name = plan.name,
      .domain = plan.domain,
      .transport = plan.transport,
      // The host of a subscriber is to show what that subscriber costs, but the switch passes multicast on to
      // all hosts.
      .udp = {.multicast = UdpSettings::Multicast::off},
      .shm = {.daemon_path = daemon_beside_program()},
      // The user's own configuration names interfaces of this machine, which other hosts do not have.
      .cyclonedds_config = "",
      .log = [self = role.get()](LogLevel level, std::string_view text) { self->note(level, text); },
  });
  if (!node) return tl::unexpected(node.error());
  role->node_.emplace(std::move(*node));
  return role;
}

std::string RoleNode::last_warning() {
  const core::Lock lock(mutex_);
  return last_warning_;
}

void RoleNode::note(LogLevel level, std::string_view text) {
  if (level < LogLevel::warning) return;
  const core::Lock lock(mutex_);
  last_warning_ = text;
}

}  // namespace sft::demo
