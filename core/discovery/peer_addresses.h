// The addresses of the peers that users name. Cyclone DDS would look names up itself whenever a link is made,
// and hold up whoever makes it for as long as a name server is silent. So Cyclone is given numbers only. Each
// lookup has a thread for itself, for which nobody waits: the thread ends with the answer, even if nobody
// wants that any more. The last good answer holds until there is another one.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/platform/clock.h"
#include "core/platform/host_lookup.h"
#include "core/platform/retry.h"
#include "core/sync/mutex.h"
#include "sft/options.h"
#include "sft/result.h"

namespace sft::core {

/// Hosts by their names, as far as their addresses are known.
using KnownHosts = std::map<std::string, std::vector<IpAddress>>;

/// Returns the host that a peer names, where the peer is not a number: of "robot.local:7410", "robot.local".
std::optional<std::string> name_in(const std::string& peer);
/// Returns the peer in numbers, as Cyclone takes them on links of that family. Empty if there are none.
std::vector<std::string> in_numbers(const std::string& peer, IpFamily family, const KnownHosts& hosts);

/// One thread at a time.
class PeerAddresses {
 public:
  using Ask = std::function<Result<std::vector<IpAddress>>(const std::string& name, IpFamily family)>;

  /// More addresses of one name are not asked.
  static constexpr std::size_t addresses_max = 4;
  /// An answer may have changed after that.
  static constexpr std::chrono::seconds ask_again_after{120};

  /// `ask` is called on threads with these settings, also when this object is gone.
  PeerAddresses(const std::vector<std::string>& peers, ThreadSettings threads, Ask ask = &addresses_of_host);

  /// Links of that family ask the peers; nothing: none does, and no name is looked up.
  void used_on(std::optional<IpFamily> family);
  /// The network has changed: names may have other addresses, and another name server may answer.
  void network_changed();

  struct Look {
    bool is_changed = false;        ///< other addresses are known
    bool is_told = false;           ///< warnings() are others
    std::vector<std::string> news;  ///< those warnings that are new
    Time next = Time::max();        ///< when it has to be called again at the latest
  };
  /// Begins the lookups that are due, and takes the answers that have come.
  Look look_after(Time now);
  /// Returns once no lookup is under way, or at the deadline.
  void wait_for_answers(Time deadline);

  const KnownHosts& known() const { return known_; }
  /// For people: which peers are not looked for, or where they may not be any more.
  std::vector<std::string> warnings() const;

 private:
  struct Answer {
    std::string name;
    IpFamily family{};
    Result<std::vector<IpAddress>> addresses;
  };
  /// Lookups write to it, and may outlive everything else.
  struct Mailbox {
    Mutex mutex;
    Condition came;
    std::vector<Answer> answers SFT_GUARDED_BY(mutex);
  };
  struct Host {
    std::optional<Time> asked_at{};  ///< if a lookup is under way
    bool is_due = true;              ///< since the last lookup began
    Time next{};                     ///< the time of the next lookup
    Retry retry{};
    std::string why_not{};  ///< the last lookup brought nothing, or has not brought anything yet
  };

  void begin(const std::string& name, Host& host, Time now);
  bool take(Answer answer, Time now);
  bool take_answers(Time now);
  std::string warning_about(const std::string& name, const Host& host) const;

  const ThreadSettings threads_;
  const Ask ask_;
  const std::shared_ptr<Mailbox> mailbox_ = std::make_shared<Mailbox>();
  std::vector<std::string> numbers_;  ///< of peers that are none of names
  std::map<std::string, Host> hosts_;
  KnownHosts known_;
  std::optional<IpFamily> family_;
  std::vector<std::string> told_;
};

}  // namespace sft::core
