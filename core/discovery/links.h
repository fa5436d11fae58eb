// Opens the links of this process that are wanted, makes links anew, and closes those that are not needed
// any more. Peers (peers.h) decides when. An object must be used by only one thread at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/discovery/control_link.h"
#include "core/discovery/dds_config.h"
#include "core/discovery/dds_domain.h"
#include "core/discovery/desired_links.h"
#include "core/discovery/known_peers.h"
#include "core/discovery/own_records.h"
#include "core/discovery/timing.h"
#include "sft/options.h"

namespace sft::core {

class Links {
 public:
  struct Settings {
    DdsConfig config;
    ThreadSettings threads;
    Timing timing;
  };
  /// `own` and `known` must outlive this object. The records in `own` are written to each link that is
  /// opened.
  Links(Settings settings, const OwnRecords& own, KnownPeers& known)
      : settings_(std::move(settings)), own_(own), known_(known) {}
  /// Waits until other participants have acknowledged the written records, but no longer than
  /// Timing::farewell_max.
  ~Links();
  Links(const Links&) = delete;
  Links& operator=(const Links&) = delete;

  /// Opens the links that are wanted, and retires all others. Returns the error of the first link that
  /// could not be opened. The next call tries such links again. If the addresses of a link's peers in
  /// `hosts` have changed, the link is replaced by a new one.
  Result<void> use(const std::vector<LinkSpec>& wanted, const KnownHosts& hosts);
  /// Replaces a link, which must not have retired, by a new one with the same spec, and returns that spec.
  Result<LinkSpec> renew(LinkId link);
  void close(LinkId link);
  void close_all();
  /// Opens and closes readers and writers on all links. Links that are opened later are included. Returns the
  /// last error; the next call does again what has failed.
  Result<void> follow(const LinkUse& use);
  /// Writes the records that could not be written before. Returns the last error.
  Result<void> write_again();

  bool empty() const { return links_.empty(); }
  /// Returns the specs of the links that have not retired.
  std::vector<LinkSpec> specs() const;
  ControlLink* find(LinkId link) const;
  /// Returns the links that could not be opened, each with the reason.
  const std::vector<std::string>& failures() const { return failures_; }
  /// Returns Cyclone's complaints about the configuration.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Calls use(link) for each link.
  template <class Use>
  void each(Use use) const {
    for (const OpenLink& one : links_) use(*one.link);
  }

 private:
  struct OpenLink {
    LinkId id = 0;
    LinkSpec spec{};
    std::string config{};  ///< the configuration with which its domain was made
    std::unique_ptr<ControlLink> link{};
    bool is_retired = false;
  };

  Result<void> open(const LinkSpec& spec, OpenLink* instead_of);
  Result<std::shared_ptr<const CycloneDomain>> open_domain(const OpenLink& link);
  Result<void> open_link(OpenLink& link);
  OpenLink* present(const LinkSpec& spec);

  const Settings settings_;
  const OwnRecords& own_;
  KnownPeers& known_;
  KnownHosts hosts_;
  LinkUse use_;
  LinkId links_made_ = 0;
  std::vector<std::string> failures_, warnings_;
  std::vector<OpenLink> links_;
};

}  // namespace sft::core
