// A node: the participant through which a program publishes and subscribes. It owns its threads; several in
// one process are fine. Publishers and subscribers keep their node alive.
#pragma once

#include <concepts>
#include <memory>
#include <string_view>
#include <utility>

#include "sft/options.h"
#include "sft/publisher.h"
#include "sft/status.h"
#include "sft/subscriber.h"

namespace sft {

class Node {
 public:
  /// Joins the control topics, opens the transports, starts the threads.
  static Result<Node> open(const NodeOptions& options = {});

  template <class T>
  Result<Publisher<T>> publisher(std::string_view topic, const PublisherOptions& options = {}) {
    return open_publisher(topic, type_support<T>(), options).map([](untyped::Publisher&& p) {
      return Publisher<T>(std::move(p));
    });
  }

  /// Declared: `node.subscriber<PointCloud2, F::height | F::width>("points")`; recorded: `<PointCloud2,
  /// sft::recorded>`.
  template <class T, Req<T> R = Req<T>(all<T>)>
  Result<Subscriber<T, R>> subscriber(std::string_view topic, const SubscriberOptions& options = {}) {
    return open_subscriber(topic, type_support<T>(), requirement<T, R>(), options, {})
        .map([](untyped::Subscriber&& s) { return Subscriber<T, R>(std::move(s)); });
  }

  template <class T, Req<T> R = Req<T>(all<T>), std::invocable<const Sample<T, R>&> F>
  Result<Subscriber<T, R>> subscriber(std::string_view topic, F&& callback,
                                      const SubscriberOptions& options = {}) {
    auto typed = [callback = std::forward<F>(callback)](untyped::Sample&& sample) mutable {
      callback(std::as_const(static_cast<const Sample<T, R>&>(Sample<T, R>(std::move(sample)))));
    };
    return open_subscriber(topic, type_support<T>(), requirement<T, R>(), options, std::move(typed))
        .map([](untyped::Subscriber&& s) { return Subscriber<T, R>(std::move(s)); });
  }

  NodeStatus status() const;

 private:
  template <class T, Req<T> R>
  static untyped::Requirement requirement() {
    return {FieldMask(R.mask), R.is_recorded};
  }

  explicit Node(std::shared_ptr<core::NodeCore> core) : core_(std::move(core)) {}
  Result<untyped::Publisher> open_publisher(std::string_view topic, const TypeSupport& type,
                                            const PublisherOptions& options);
  Result<untyped::Subscriber> open_subscriber(std::string_view topic, const TypeSupport& type,
                                              untyped::Requirement requirement,
                                              const SubscriberOptions& options, untyped::Callback callback);

  std::shared_ptr<core::NodeCore> core_;
};

}  // namespace sft
