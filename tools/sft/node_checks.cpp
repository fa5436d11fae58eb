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

bool has(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

Finding interfaces_of(const NodeStatus& status) {
  const bool misses = has(status.discovery, "is not there") || has(status.discovery, "no network yet") ||
                      has(status.discovery, "does not hold");
  return {"interfaces", misses ? Health::warning : Health::ok, status.discovery,
          misses ? "Look at the interfaces (ip addr) and at the settings that are named." : ""};
}

Finding udp_of(const NodeStatus& status) {
  if (!has(status.udp, "io_uring")) {
    return {"io_uring", Health::warning, status.udp,
            "Plain sockets do the same work, and take more processor time."};
  }
  const bool refused = has(status.udp, "cannot be used");
  return {"io_uring", refused ? Health::warning : Health::ok, status.udp,
          refused ? "Plain sockets do the same work meanwhile; the text says what to change." : ""};
}

/// A node that finds no daemon starts one, which this node does not.
Finding daemon_of(const NodeStatus& status) {
  if (status.shm_ready) return {"sftd", Health::ok, status.shm};
  if (has(status.shm, "no sftd is running"))
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
          self.status.discovery};
}

}  // namespace sft::tool
