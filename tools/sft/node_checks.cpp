#include "tools/sft/node_checks.h"

#include <fmt/format.h>

#include <chrono>
#include <set>
#include <string>

#include "tools/sft/session.h"
#include "tools/sft/units.h"

namespace sft::tool {

namespace {

using namespace std::chrono_literals;

Finding interfaces_of(const NodeStatus& status) {
  const bool is_well = status.discovery_warnings.empty() && !status.waits_for_network;
  return {"interfaces", is_well ? Health::ok : Health::warning, status.discovery,
          is_well ? "" : "Look at the interfaces (ip addr) and at the settings that are named."};
}

/// Which of the two it is, and why, is what the library says.
Finding udp_of(const NodeStatus& status) {
  if (status.io_uring_in_use) return {"io_uring", Health::ok, status.udp};
  return {"io_uring", Health::warning, status.udp,
          "Plain sockets do the same work meanwhile, and take more processor time."};
}

/// A node that finds no daemon starts one, which this node does not.
Finding daemon_of(const NodeStatus& status) {
  if (status.shm_ready) return {"sftd", Health::ok, status.shm};
  if (status.lacks_daemon)
    return {"sftd", Health::ok, "none is running; the first program that wants it starts it"};
  return {"sftd", Health::warning, status.shm, "Samples within this host go by UDP: see 'sftd status'."};
}

Finding domain_of(const NodeSnapshot& self, const DomainSnapshot& domain) {
  std::set<std::uint64_t> nodes;
  for (const auto* endpoints : {&domain.publishers, &domain.subscribers})
    for (const EndpointInfo& e : *endpoints) nodes.insert(e.node_id);
  const std::uint64_t refused = self.status.control_malformed + self.status.control_ignored;
  const std::string text =
      fmt::format("domain {}, SFT {}, protocol {}: {} with publishers or subscribers", self.domain,
                  self.version, self.control_protocol, count_text(nodes.size(), "node"));
  if (refused == 0) return {"domain", Health::ok, text};
  return {"domain", Health::warning, text + fmt::format("; {} refused", count_text(refused, "announcement")),
          "Somebody speaks another version of the protocol, or says what cannot be: see the logs of nodes."};
}

}  // namespace

NodeFindings check_node(const CommonOptions& common, Stop& stop, Output& output) {
  Result<Session> session = Session::open(common, "doctor", stop, output);
  if (!session) {
    return {{{"node", Health::error, "no node can be opened: " + session.error().message,
              "No program of SFT works here until that is mended."}}};
  }
  const DomainSnapshot domain = session->look_around();
  const NodeSnapshot self = session->node().snapshot();
  return {{interfaces_of(self.status), udp_of(self.status), daemon_of(self.status), domain_of(self, domain)},
          self.status.discovery_interfaces};
}

}  // namespace sft::tool
