// Brings the transports to the states that the negotiation wants: opens and closes ports, sets routes,
// connects readers, announces, and looks after what changes by itself. All of it on the node's agent thread,
// except where said otherwise.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/discovery/discovery.h"
#include "core/negotiation/accepted_requests.h"
#include "core/negotiation/negotiation.h"
#include "core/negotiation/qos_watch.h"
#include "core/node/account_answers.h"
#include "core/node/account_questions.h"
#include "core/node/arrival_watchdog.h"
#include "core/node/control_outbox.h"
#include "core/node/control_watch.h"
#include "core/node/domain_snapshot.h"
#include "core/node/silence_watch.h"
#include "core/platform/retry.h"
#include "core/platform/turns.h"
#include "core/publish/publisher_core.h"
#include "core/report/node_log.h"
#include "core/seam/transport.h"
#include "core/subscribe/dispatcher.h"
#include "core/subscribe/recorder.h"
#include "core/subscribe/subscriber_core.h"
#include "sft/options.h"

namespace sft::core {

class Reconciler {
 public:
  /// All that it is given outlives it; a transport is null where the node must not use it.
  Reconciler(NodeId id, std::uint64_t network, Transport* shm, Transport* udp, Discovery& discovery,
             Dispatcher& dispatcher, NodeLog& log);

  struct NewReader {
    std::shared_ptr<SubscriberCore> core;
    std::shared_ptr<Recorder> recorder;  ///< null unless the requirement is recorded
    std::shared_ptr<ReaderPort> udp;     ///< null where UDP is ruled out; accepts the first mask already
  };
  void add_writer(const Endpoint& endpoint, std::shared_ptr<PublisherCore> core);
  void add_reader(const Endpoint& endpoint, NewReader reader);
  /// Withdraws an endpoint and lets go of its ports.
  void remove(EndpointId id);
  /// What the recorder of one of our readers found.
  void requirement_changed(EndpointId id);
  /// One of our readers may ask for another maximum rate.
  void rate_changed(EndpointId id);

  // What discovery reports.
  void endpoint_seen(const Endpoint& endpoint);
  void endpoint_departed(EndpointId id);
  void endpoint_lost(EndpointId id);
  void request_received(const Request& request);
  void liveliness_asserted(const Assertion& assertion, Now now = std::chrono::steady_clock::now());
  void node_lost(NodeId id);

  /// The program has asserted the liveliness of one of our writers.
  void program_asserts(EndpointId writer);

  /// Those that are known and not lost, ours too. Valid until the next event.
  std::vector<const Endpoint*> endpoints() const { return negotiation_.present(); }
  /// The same, with how far the writers are.
  std::vector<KnownEndpoint> known_endpoints() const;

  /// The program wants to know the accounts of all pairs on that topic, or not any more, once for each time
  /// that it wanted to.
  void ask_accounts(const std::string& topic) { questions_.ask(topic); }
  void ask_accounts_no_more(const std::string& topic) { questions_.ask_no_more(topic); }
  /// What is known of the pairs that the program asks about.
  PairAccounts known_accounts(Now now = std::chrono::steady_clock::now());

  /// Looks after transports and time; returns when to be called again.
  std::chrono::milliseconds tick(Now now = std::chrono::steady_clock::now());
  /// After any of the above: makes what has changed come true.
  void reconcile();

  // Any thread.
  bool shm_ready() const { return shm_ready_.load(); }
  std::string shm_state() const;
  std::uint64_t control_ignored() const { return control_ignored_.load(std::memory_order_relaxed); }

 private:
  struct Writer {
    std::shared_ptr<PublisherCore> core;
    std::shared_ptr<WriterPort> shm;
    Retry opening_shm{};
    std::optional<Serving> in_force;
    OfferWatch watch;
    std::set<EndpointId> history_sent{};     ///< to these late readers, at the last tick: all there was
    std::uint64_t progress_told = 0;         ///< samples published when others were told of it last
    PublisherStatus told;                    ///< the state up to which its events were told
    bool has_news = false;                   ///< since then it may have changed
    std::map<EndpointId, Retry> reaching{};  ///< readers in memory that could not be told of samples
  };
  struct Connecting {
    Retry shm;
    Retry udp;
    std::chrono::seconds udp_preferred{0};  ///< for so long, when shared memory was deaf last
  };
  struct Reader {
    std::shared_ptr<SubscriberCore> core;
    std::shared_ptr<Recorder> recorder;
    std::shared_ptr<ReaderPort> shm;
    std::shared_ptr<ReaderPort> udp;
    std::map<EndpointId, Hearing> heard;
    std::map<EndpointId, Connecting> connecting;  ///< to these
    std::map<EndpointId, RequestWatch> watched;   ///< of these
    std::map<EndpointId, ArrivalWatchdog> watchdogs;
    int looks_in_callback = 0;  ///< at which it was called back, in a row
    Qos requested;
    AcceptedRequests accepted;
    std::map<EndpointId, Now> departed;  ///< writers of which datagrams may still be in flight
    SubscriberStatus told;
    bool has_news = false;
    std::uint64_t losses_told = 0;
  };

  void heard_of(const Endpoint& endpoint);
  void watch_promises(Now now);
  bool watch_offer(Writer& writer, Now now);
  void look_after_histories();
  bool look_after_history(EndpointId reader, const ReaderPort& port, EndpointId writer);
  bool is_ours(EndpointId id) const { return writers_.contains(id) || readers_.contains(id); }
  void tell_of_life(std::vector<EndpointId> writers, Now now);
  Assertion sign_of_life(std::vector<EndpointId> writers, Now now);
  std::vector<Progress> progress_to_tell();
  std::vector<EndpointId> questions_to_ask();
  std::vector<Account> accounts_to_tell(Now now);
  void add_accounts_of(EndpointId own, std::set<AccountId>& accounts) const;
  Account account(const AccountId& id) const;
  void look_for_callbacks_under_way(Now now);
  void look_for_the_deaf(const Assertion& assertion, Now now);
  bool is_deaf(EndpointId id, Reader& reader, const Hearing& hearing, const Assertion& assertion, Now now);
  void restart(EndpointId id, Reader& reader, Hearing& hearing, Now now);
  static void watch(Reader& reader);
  std::chrono::milliseconds pace() const;
  void look_after_shm();
  void tell_of_shm(Availability availability);
  void look_after_udp(Now now);
  void look_after_addresses(Now now);
  bool look_after_connections();
  void forget_what_was_in_flight(Now now);
  void drop_shm_ports();
  void let_go_of_the_left();

  void apply_desired_states();
  void reconcile_writer(EndpointId id, Writer& writer);
  Serving reachable(EndpointId id, Writer& writer, Serving wanted);
  void look_after_reach(Now now);
  void reconcile_reader(EndpointId id, Reader& reader);
  std::size_t count_unattached() const;
  Hearing connect(EndpointId id, Reader& reader, const Hearing& wanted, const Hearing& before);
  Result<void> connect_shm(EndpointId id, Reader& reader, const Source& source);
  bool try_shm(Retry& retry, const std::function<Result<void>()>& open);
  bool try_udp(Retry& retry, Reader& reader, const Source& source);
  bool may_try_again(Now now) const;

  void settle();
  void tell_what_happened();
  template <class Member>
  void tell(Member& member);
  static std::vector<Event> differences(const Writer& writer, const PublisherStatus& now);
  static std::vector<Event> differences(const Reader& reader, const SubscriberStatus& now);

  void announce(EndpointId id);
  void request_changed(EndpointId id);
  void take_back_what_is_ours(Now now);
  void asks_for(Reader& reader, const Wanted& wanted);
  static void accept(Reader& reader);

  const NodeId id_;
  Transport* const shm_;
  Transport* const udp_;
  Discovery& discovery_;
  Dispatcher& dispatcher_;
  NodeLog& log_;

  Negotiation negotiation_;
  ControlOutbox outbox_;
  ControlWatch control_watch_;
  SilenceWatch silence_;
  std::map<EndpointId, Writer> writers_;
  std::map<EndpointId, Reader> readers_;
  std::vector<Reader> leaving_;  ///< removed within callbacks that have not returned yet
  Self self_;
  std::string shm_why_not_;  ///< as it was written to the log last; empty while it may come up
  bool shm_warned_ = false;
  bool udp_failed_ = false;
  std::vector<UdpAddress> addresses_;  ///< as they were announced
  std::vector<Link> links_;
  Now next_look_at_addresses_{};
  Now told_of_life_at_{};
  Now told_more_at_{};  ///< than that we live
  Turns<EndpointId> progress_turns_;
  AccountQuestions questions_;
  AccountAnswers answers_;
  Now held_up_at_{};    ///< by a callback
  bool dirty_ = false;  ///< something changed that reconcile() has not seen
  Retry asking_daemon_;
  std::size_t unattached_ = 0;  ///< connections in shared memory whose publishers have not shown up
  int hurried_ticks_ = 0;       ///< in a row, because some reader waits for its connection

  std::atomic<bool> shm_ready_{false};
  std::atomic<std::uint64_t> control_ignored_{0};
  mutable std::mutex shm_state_mutex_;
  std::string shm_state_ = "starting";
};

}  // namespace sft::core
