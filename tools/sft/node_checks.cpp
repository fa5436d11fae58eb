#include "tools/sft/node_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tools/sft/chunk_check.h"
#include "tools/sft/dds_checks.h"
#include "tools/sft/describe.h"
#include "tools/sft/session.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

using namespace std::chrono_literals;

Finding interfaces_of(const NodeStatus& status) {
  const bool is_well = status.discovery_warnings.empty() && !status.waits_for_network;
  return {"interfaces", is_well ? Health::ok : Health::warning, status.discovery,
          is_well ? "" : "Check the interfaces (ip addr) and the settings that this names."};
}

/// Returns the finding about a quick path, from the library's report whether the path is used, and why not.
Finding quick_path_of(const NodeStatus::QuickPath& path) {
  if (path.why_not.empty()) return {path.name, Health::ok, "used"};
  return {path.name, Health::warning, "not used: " + path.why_not,
          "All works without it, and takes more processor time."};
}

/// Returns the finding about the daemon. Other nodes start a daemon if none is running. This node never
/// starts a daemon, so a missing daemon is not a fault.
Finding daemon_of(const NodeStatus& status) {
  if (status.shm_ready) return {"sftd", Health::ok, status.shm};
  if (status.lacks_daemon)
    return {"sftd", Health::ok, "no sftd is running; the first program that needs it starts it"};
  return {"sftd", Health::warning, status.shm, "Samples within this host go by UDP: see 'sftd status'."};
}

Finding domain_of(const NodeSnapshot& self, const DomainSnapshot& domain) {
  std::set<std::uint64_t> nodes;
  for (const auto* endpoints : {&domain.publishers, &domain.subscribers})
    for (const DomainSnapshot::Endpoint& e : *endpoints)
      if (!e.dds) nodes.insert(e.node_id);
  const std::uint64_t refused = self.status.control_malformed + self.status.control_ignored;
  const std::string text =
      fmt::format("domain {}, SFT {}, protocol {}: {} with publishers or subscribers", self.domain,
                  self.version, self.control_protocol, count_text(nodes.size(), "node"));
  if (refused == 0) return {"domain", Health::ok, text};
  return {
      "domain", Health::warning, text + fmt::format("; {} refused", count_text(refused, "announcement")),
      "Another node speaks another version of the protocol, or announces what is invalid: see the logs of "
      "nodes."};
}

/// Waits for a while, and returns the domain as it is known then, with the counts of the publishers on this
/// host.
DomainSnapshot look_around(Session& session) {
  constexpr double longest_s = 3;  // the first answers come after about a second
  DomainSnapshot domain = session.look_around();
  std::map<std::string, Result<AccountInquiry>> inquiries;  // one for each topic
  const auto has_accounts = [&](const DomainSnapshot::Pair& pair) {
    const auto* const publisher = endpoint_of(pair.publisher, domain.publishers);
    const bool is_asked_about = publisher != nullptr && publisher->same_machine && pair.connected &&
                                pair.transport == TransportKind::shm;
    if (is_asked_about && !inquiries.contains(publisher->topic))
      inquiries.emplace(publisher->topic, session.node().ask_accounts("/" + publisher->topic));
    return !is_asked_about || pair.account.publisher;
  };
  session.wait_until(
      [&](const DomainSnapshot& now) {
        domain = now;
        // has_accounts() is called for each pair, because it also opens the inquiries
        return std::ranges::count_if(now.pairs, has_accounts) == std::ssize(now.pairs);
      },
      longest_s);
  session.wait_until(all_dds_nodes_have_answered, dds_answers_within_s);
  return session.domain();
}

}  // namespace

NodeFindings check_node(const CommonOptions& common, Stop& stop, Output& output) {
  Result<Session> session = Session::open(common, "doctor", stop, output);
  if (!session) {
    return {{{"node", Health::error, "no node can be opened: " + session.error().message,
              "No program that uses SFT works on this host until this is corrected."}}};
  }
  const DomainSnapshot domain = look_around(*session);
  const NodeSnapshot self = session->node().snapshot();
  std::vector<Finding> findings{interfaces_of(self.status), {"udp", Health::ok, self.status.udp}};
  std::ranges::transform(self.status.quick_paths, std::back_inserter(findings), quick_path_of);
  findings.push_back(daemon_of(self.status));
  findings.push_back(check_chunks(domain));
  findings.push_back(domain_of(self, domain));
  return {std::move(findings), self.status.discovery_interfaces, domain};
}

}  // namespace sft::tool
