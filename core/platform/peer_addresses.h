// The addresses of the peers that users name. Cyclone DDS would look up names itself whenever a link is
// made, and would block the thread that makes the link while a name server does not answer. So Cyclone gets
// numeric addresses only. Each lookup has its own thread, so that no other thread depends on the answer.
// The thread of a lookup ends when the answer arrives, even if the answer is not needed any more. If a
// later lookup fails, the last good answer remains in use.
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

/// The addresses of hosts, by their names. The map contains only hosts whose addresses are known.
using KnownHosts = std::map<std::string, std::vector<IpAddress>>;

/// Returns the host name in a peer: "robot.local" in "robot.local:7410". Returns nothing if the peer is a
/// numeric address.
std::optional<std::string> name_in(const std::string& peer);
/// Returns the numeric addresses of a peer, in the form that Cyclone accepts on links of the given family.
/// The result is empty if no address is known.
std::vector<std::string> in_numbers(const std::string& peer, IpFamily family, const KnownHosts& hosts);

/// Keeps the addresses of the peers that are given by name, and looks the names up again and again. An
/// object must be used by only one thread at a time.
class PeerAddresses {
 public:
  using Ask = std::function<Result<std::vector<IpAddress>>(const std::string& name, IpFamily family)>;

  /// The maximum number of addresses of one name. Further addresses are ignored.
  static constexpr std::size_t addresses_max = 4;
  /// The time after which a name is looked up again, since its address may have changed.
  static constexpr std::chrono::seconds ask_again_after{120};

  /// `ask` is called on threads with the settings `threads`, possibly even after this object was destroyed.
  PeerAddresses(const std::vector<std::string>& peers, ThreadSettings threads, Ask ask = &addresses_of_host);

  /// Sets the IP family of the links that use the peers. If it is empty, no name is looked up.
  void used_on(std::optional<IpFamily> family);
  /// Called when the network has changed. Names are looked up again, since they may have other addresses, and
  /// another name server may answer.
  void network_changed();

  struct Look {
    bool addresses_changed = false;  ///< known() has changed
    bool warnings_changed = false;   ///< warnings() have changed
    std::vector<std::string> news;   ///< the new warnings
    Time next = Time::max();         ///< the latest time for the next call
  };
  /// Begins the lookups that are due, and takes the answers that have arrived.
  Look look_after(Time now);
  /// Waits until no lookup is running, or until the deadline.
  void wait_for_answers(Time deadline);

  const KnownHosts& known() const { return known_; }
  /// Returns warnings for people about peers that discovery cannot search, or searches only at their last
  /// known addresses.
  std::vector<std::string> warnings() const;

 private:
  struct Answer {
    std::string name;
    IpFamily family{};
    Result<std::vector<IpAddress>> addresses;
  };
  /// The answers of lookups. The threads of lookups share ownership of the mailbox, since they may outlive
  /// the PeerAddresses that started them.
  struct Mailbox {
    Mutex mutex;
    Condition came;
    std::vector<Answer> answers SFT_GUARDED_BY(mutex);
  };
  struct Host {
    std::optional<Time> asked_at{};  ///< the time when the running lookup began; empty: none is running
    bool is_due = true;              ///< true: a lookup has to begin now, even if the time `next` has not
                                     ///< come yet
    Time next{};                     ///< the time of the next lookup
    Retry retry{};
    std::string why_not{};  ///< the reason why the last lookup has found no address; empty if it has found
                            ///< one or is still running
  };

  void begin(const std::string& name, Host& host, Time now);
  bool take(Answer answer, Time now);
  bool take_answers(Time now);
  std::string warning_about(const std::string& name, const Host& host) const;

  const ThreadSettings threads_;
  const Ask ask_;
  const std::shared_ptr<Mailbox> mailbox_ = std::make_shared<Mailbox>();
  std::vector<std::string> numbers_;  ///< the peers that users named by numeric addresses
  std::map<std::string, Host> hosts_;
  KnownHosts known_;
  std::optional<IpFamily> family_;
  std::vector<std::string> last_warnings_;
};

}  // namespace sft::core
