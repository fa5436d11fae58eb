// A node: the participant through which a program publishes and subscribes. It owns its threads; several in
// one process are fine. Publishers and subscribers keep their node alive.
//
// fork() is harmless: in the new process the node, and all that it opened or lent, may be destroyed, which
// does nothing, and the process may begin another program (exec) or end. Nothing else may be done with them
// there, and no other node can be opened.
//
// All functions of a node may be called by any thread, also at once, and within callbacks of its publishers
// and subscribers, but for find_type(). Copies are the same node. What a node has opened may call back before
// the function that opened it has returned.
//
// Topics are names in UTF-8 of up to 255 bytes, with slashes in them as one likes: "points", "left/points". A
// slash in front is taken away: "/points" and "points" are one topic, which is shown as "points" wherever it
// is shown.
#pragma once

#include <chrono>
#include <concepts>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "sft/domain.h"
#include "sft/dynamic.h"
#include "sft/options.h"
#include "sft/publisher.h"
#include "sft/snapshot.h"
#include "sft/status.h"
#include "sft/subscriber.h"

namespace sft {

/// A participant: opens publishers and subscribers. A handle: copies are the same node.
class Node {
 public:
  /// Joins the control topics, opens the transports, starts the threads.
  static Result<Node> open(const NodeOptions& options = {});

  /// Opens a publisher of messages of type T.
  template <class T>
  Result<Publisher<T>> publisher(std::string_view topic, const PublisherOptions& options = {}) {
    return open_publisher(topic, type_support<T>(), options).map([](detail::untyped::Publisher&& p) {
      return Publisher<T>(std::move(p));
    });
  }

  /// Declared: `node.subscriber<PointCloud2, F::height | F::width>("points")`; recorded: `<PointCloud2,
  /// sft::recorded>`. Of a field that is a sequence or an array of structs, `fields` say, `F::fields` names
  /// all of it, `F::fields.each.name` one member of each element and `F::fields.size` how many there are
  /// (sequences only); with a member their number always comes. In text these are "fields", "fields[].name"
  /// and "fields.size".
  template <class T, Req<T> R = Req<T>(all<T>)>
  Result<Subscriber<T, R>> subscriber(std::string_view topic, const SubscriberOptions& options = {}) {
    return open_subscriber(topic, type_support<T>(), requirement<T, R>(), options, {})
        .map([](detail::untyped::Subscriber&& s) { return Subscriber<T, R>(std::move(s)); });
  }

  template <class T, Req<T> R = Req<T>(all<T>), detail::SampleCallback<Sample<T, R>> F>
  Result<Subscriber<T, R>> subscriber(std::string_view topic, F&& callback,
                                      const SubscriberOptions& options = {}) {
    auto typed = [callback = std::forward<F>(callback)](detail::untyped::Sample&& untyped) mutable {
      Sample<T, R> sample(std::move(untyped));
      if constexpr (std::invocable<F&, const Sample<T, R>&>) {
        callback(std::as_const(sample));
      } else {
        callback(std::move(sample));
      }
    };
    return open_subscriber(topic, type_support<T>(), requirement<T, R>(), options, std::move(typed))
        .map([](detail::untyped::Subscriber&& s) { return Subscriber<T, R>(std::move(s)); });
  }

  /// Only says what a callback takes, where it takes something else.
  template <class T, Req<T> R = Req<T>(all<T>), class F>
  requires(!detail::SampleCallback<F, Sample<T, R>> && !std::convertible_to<F, const SubscriberOptions&>)
      Result<Subscriber<T, R>> subscriber(std::string_view, F&&, const SubscriberOptions& = {}) {
    static_assert(sizeof(F) == 0,
                  "the callback of a subscriber takes a sample and not the message: write [](const auto& "
                  "sample) { ... sample->field() ... }, or name the type, const sft::Sample<T, R>&");
    return fail(Errc::invalid_argument, "no callback for samples");
  }

  // For programs that were not compiled with the type of a topic (dynamic.h).

  /// Waits until somebody who publishes the topic (or, if nobody does, subscribes to it) has announced its
  /// type. The error says what was seen instead. Not for callbacks: it would hold up the node (in
  /// on_readers_changed it does not wait).
  Result<DynamicType> find_type(std::string_view topic, std::chrono::nanoseconds timeout);
  /// All topics that are known at present, those of this node too.
  std::vector<TopicInfo> topics() const;
  /// All publishers and subscribers that are known at present, those of this node too, and how each pair
  /// stands.
  DomainSnapshot domain() const;
  /// As long as what it returns lives, domain() also has what both sides of each pair on that topic have
  /// counted (domain.h).
  Result<AccountInquiry> ask_accounts(std::string_view topic) const;
  /// `fields` as text: "header.stamp, fields[].name", "*" for all. Without a callback samples are taken.
  Result<DynamicSubscriber> subscriber(std::string_view topic, const DynamicType& type,
                                       std::string_view fields, const SubscriberOptions& options = {},
                                       DynamicCallback callback = {});
  /// Recorded: `node.subscriber("points", type, sft::recorded)`.
  Result<DynamicSubscriber> subscriber(std::string_view topic, const DynamicType& type, Recorded,
                                       const SubscriberOptions& options = {}, DynamicCallback callback = {});

  /// Publishes what is encoded already, or JSON. The node keeps the type until it is closed, once for all
  /// publishers of it.
  Result<DynamicPublisher> publisher(std::string_view topic, const DynamicType& type,
                                     const PublisherOptions& options = {});

  /// How discovery and the transports work at present.
  NodeStatus status() const;
  /// All that the node knows of its publishers, its subscribers and itself (snapshot.h); to_json() writes it.
  NodeSnapshot snapshot() const;

 private:
  template <class T, Req<T> R>
  static detail::untyped::Requirement requirement() {
    return {FieldMask(R.mask), R.is_recorded};
  }

  explicit Node(std::shared_ptr<core::NodeCore> core) : core_(std::move(core)) {}
  Result<detail::untyped::Publisher> open_publisher(std::string_view topic, const TypeSupport& type,
                                                    const PublisherOptions& options);
  Result<detail::untyped::Subscriber> open_subscriber(std::string_view topic, const TypeSupport& type,
                                                      detail::untyped::Requirement requirement,
                                                      const SubscriberOptions& options,
                                                      detail::untyped::Callback callback);
  Result<DynamicSubscriber> open_subscriber(std::string_view topic, const DynamicType& type,
                                            detail::untyped::Requirement requirement,
                                            const SubscriberOptions& options, DynamicCallback callback);

  std::shared_ptr<core::NodeCore> core_;
};

}  // namespace sft
