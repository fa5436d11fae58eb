// Opens the links of this process that are wanted, makes links anew, and closes those that are not needed any
// more. Peers (peers.h) decides when. One thread at a time.
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
  /// `own` and `known` outlive this object. The records of `own` are written to each link that is opened.
  Links(Settings settings, const OwnRecords& own, KnownPeers& known)
      : settings_(std::move(settings)), own_(own), known_(known) {}
  /// Waits until other participants have acknowledged what was written, for Timing::farewell_max at most.
  ~Links();
  Links(const Links&) = delete;
  Links& operator=(const Links&) = delete;

  /// Opens the links that are wanted, and retires others. Returns the error of the first link that could not
  /// be opened. The next call tries such links again. A link is made anew if `hosts` has other addresses for
  /// its peers than before.
  Result<void> use(const std::vector<LinkSpec>& wanted, const KnownHosts& hosts);
  struct Renewal {
    bool is_made = false;
    std::string text{};  ///< for people; empty if it failed as it did before
  };
  /// Makes a link anew. Returns nothing if the link does not exist, or has retired.
  std::optional<Renewal> renew(LinkId link, const std::string& why);
  void close(LinkId link);
  void close_all();
  /// Starts to read, on all links, what other participants announce for that role. Links that are opened
  /// later are included.
  Result<void> hear(Role role);
  /// Reads or writes reports on all links. Links that are opened later are included.
  Result<void> use_reports(bool reads, bool writes);
  /// Opens the readers and writes the records for which this failed before. Returns the last error.
  Result<void> try_again();

  bool empty() const { return links_.empty(); }
  /// Returns the specs of the links that have not retired.
  std::vector<LinkSpec> specs() const;
  ControlLink* find(LinkId link) const;
  /// Links that could not be opened, and why.
  const std::vector<std::string>& failures() const { return failures_; }
  /// Returns what Cyclone complains of in the configuration.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Calls use(id, link) for each link.
  template <class Use>
  void each(Use use) const {
    for (const OpenLink& one : links_) use(one.id, *one.link);
  }

 private:
  struct OpenLink {
    LinkId id = 0;
    LinkSpec spec{};
    std::string config{};  ///< the text that `domain` was made with
    std::shared_ptr<const CycloneDomain> domain{};
    std::unique_ptr<ControlLink> link{};
    bool is_retired = false;
    std::string failure{};  ///< why it could not be made anew the last time
  };

  Result<void> open(const LinkSpec& spec, OpenLink* instead_of);
  Result<void> open_domain(OpenLink& link, const CycloneDomain* instead_of);
  Result<void> open_link(OpenLink& link);
  OpenLink* present(const LinkSpec& spec);

  const Settings settings_;
  const OwnRecords& own_;
  KnownPeers& known_;
  KnownHosts hosts_;
  PerRole<bool> heard_{};
  bool reads_reports_ = false, writes_reports_ = false;
  LinkId links_made_ = 0;
  std::vector<std::string> failures_, warnings_;
  std::vector<OpenLink> links_;
};

}  // namespace sft::core
