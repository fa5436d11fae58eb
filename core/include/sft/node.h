// The node: the participant through which a program publishes and subscribes.
//
// A Node is a handle: copies refer to the same node. The node owns its threads, and lives as long as any
// handle, publisher or subscriber of it exists. A process may have several nodes.
//
// Any thread may call any function of a node. Several threads may do so at once. Callbacks of the node's
// publishers and subscribers may call all functions except find_type(). A publisher or subscriber may call
// back before the function that opens it has returned. Functions that return a Result never throw; the
// error says what is wrong and what to do.
//
// A program with a node may call fork(). In the new process the node, and all objects that it has opened or
// lent, may be destroyed, which has no effect. The new process may start another program (exec) or end. It
// must not use these objects in any other way, and cannot open another node.
//
// A topic is a name in UTF-8 of up to 255 bytes, which may have slashes: "points", "left/points". An
// absolute name has a leading slash, which is not shown. A private name begins with "~". Any other name is
// relative, and belongs to the namespace of the node (NodeOptions::namespace_). So in a node without a
// namespace, "/points" and "points" are the same topic. The "~" of a private name stands for the full name
// of the node: in the node "cam" of the namespace "left", "~/image" is "left/cam/image". Remapping rules
// (NodeOptions::remap) then replace the name. All functions that take a topic resolve its name in this way.
// Functions that return topics return the resulting names, without a leading slash.
#pragma once

#include <chrono>
#include <concepts>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "sft/detail/declared_selection.h"
#include "sft/domain.h"
#include "sft/dynamic.h"
#include "sft/options.h"
#include "sft/publisher.h"
#include "sft/snapshot.h"
#include "sft/status.h"
#include "sft/subscriber.h"

namespace sft {

/// A handle to a node; see the beginning of this header for threads and lifetimes.
class [[nodiscard]] Node {
 public:
  /// Joins the control topics, opens the transports and starts the threads. Returns an error if a setting
  /// is wrong, if the system refuses it, or if a limit of the process is too low. A missing daemon of
  /// shared memory is no error: NodeStatus::shm reports it, and samples are sent by UDP.
  [[nodiscard]] static Result<Node> open(const NodeOptions& options = {});

  /// Opens a publisher of messages of type T.
  template <class T>
  [[nodiscard]] Result<Publisher<T>> publisher(std::string_view topic, const PublisherOptions& options = {}) {
    return open_publisher(topic, type_support<T>(), options).map([](detail::untyped::Publisher&& p) {
      return Publisher<T>(std::move(p));
    });
  }

  /// Opens a subscriber without a callback: the program takes its samples. With declared fields:
  /// `node.subscriber<PointCloud2, F::height | F::width>("points")`; with recorded fields: `<PointCloud2,
  /// sft::recorded>`. If the field `fields` is a sequence of structs, `F::fields` is the whole sequence,
  /// `F::fields.each.name` one member of each element, and `F::fields.size` the number of elements, which
  /// is also sent with any member. An array of structs has no `size`. As text these are "fields",
  /// "fields[].name" and "fields.size". A part of a field is declared like a field: `F::data.channels<"x",
  /// "y", "z">`, `F::ranges.every(4)` (detail/declared_part.h, and selection.md for its meaning). With
  /// `<PointCloud2, sft::selected>` the text SubscriberOptions::selection chooses the fields at run time.
  template <class T, Req<T> R = Req<T>(all<T>)>
  [[nodiscard]] Result<Subscriber<T, R>> subscriber(std::string_view topic,
                                                    const SubscriberOptions& options = {}) {
    return open_subscriber(topic, type_support<T>(), requirement<T, R>(), options, {})
        .map([](detail::untyped::Subscriber&& s) { return Subscriber<T, R>(std::move(s)); });
  }

  /// Opens a subscriber that calls `callback` with each sample. The callback takes a `const Sample<T, R>&`,
  /// or a `Sample<T, R>`, which it may keep.
  template <class T, Req<T> R = Req<T>(all<T>), detail::SampleCallback<Sample<T, R>> F>
  [[nodiscard]] Result<Subscriber<T, R>> subscriber(std::string_view topic, F&& callback,
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

  /// An overload for arguments that are not a callback. A call of it never compiles; the compiler's message
  /// says which arguments a callback takes.
  template <class T, Req<T> R = Req<T>(all<T>), class F>
  requires(!detail::SampleCallback<F, Sample<T, R>> && !std::convertible_to<F, const SubscriberOptions&>)
      Result<Subscriber<T, R>> subscriber(std::string_view, F&&, const SubscriberOptions& = {}) {
    static_assert(sizeof(F) == 0,
                  "the callback of a subscriber takes a sample and not the message: write [](const auto& "
                  "sample) { ... sample->field() ... }, or name the type, const sft::Sample<T, R>&");
    return fail(Errc::invalid_argument, "no callback for samples");
  }

  // The functions for programs that were not compiled with the type of a topic (dynamic.h).

  /// Waits until a publisher of the topic has announced the type, and returns that type. If no publisher
  /// appears within a second (or longer, while other processes are still being discovered), returns the
  /// type that a subscriber has announced. The error says which announcements were received instead. If a
  /// callback calls this function, the other callbacks of the node are delayed.
  Result<DynamicType> find_type(std::string_view topic, std::chrono::nanoseconds timeout);
  /// Returns all topics that are known at present, including those of this node.
  ///
  /// By default a node is notified only of publishers and subscribers that may match its own. After the
  /// first call of topics(), domain() or ask_accounts() it is notified of all publishers and subscribers.
  /// Topics that were not known at the time of that call are known soon after it.
  std::vector<TopicInfo> topics() const;
  /// Returns all publishers and subscribers that are known at present, including those of this node, and the
  /// state of each pair (domain.h).
  DomainSnapshot domain() const;
  /// While the returned object lives, domain() also contains the counts of both sides of each pair on this
  /// topic (domain.h).
  Result<AccountInquiry> ask_accounts(std::string_view topic) const;
  /// Opens a subscriber of a topic of any type. `fields` is a text: "header.stamp, fields[].name", or "*"
  /// for all fields. The text may contain parts of fields in the form of TypeSupport::parse_selection():
  /// "data{x,y,z}[::4]". Publishers on other hosts send only the requested part of a field; in shared
  /// memory the part is read from the whole sample. Without a callback the program takes the samples.
  [[nodiscard]] Result<DynamicSubscriber> subscriber(std::string_view topic, const DynamicType& type,
                                                     std::string_view fields,
                                                     const SubscriberOptions& options = {},
                                                     DynamicSubscriber::Callback callback = {});
  /// Opens a subscriber of any type with recorded fields: `node.subscriber("points", type, sft::recorded)`.
  [[nodiscard]] Result<DynamicSubscriber> subscriber(std::string_view topic, const DynamicType& type,
                                                     detail::Recorded, const SubscriberOptions& options = {},
                                                     DynamicSubscriber::Callback callback = {});

  /// Opens a publisher of messages of any type, which are already encoded, or are given as JSON or YAML.
  /// The node keeps one copy of the type for all its publishers of that type, until the node is closed.
  [[nodiscard]] Result<DynamicPublisher> publisher(std::string_view topic, const DynamicType& type,
                                                   const PublisherOptions& options = {});

  /// Ends all present and later waits in this node. Subscriber::wait() of each of its subscribers returns
  /// at once, with false if there is no sample; the file descriptors of the subscribers become readable and
  /// stay readable; and find_type() fails. All other functions continue to work. A signal handler may call
  /// this function: `while (!node.is_interrupted())` is a loop that ends at Ctrl-C (guide.md). The effect
  /// is permanent.
  void interrupt() noexcept;
  bool is_interrupted() const noexcept;  ///< true once interrupt() was called

  /// Returns the time of the node, which time_message() (time.h) converts to a stamp. By default it is the
  /// system's time. With NodeOptions::use_sim_time it is the latest time from the topic "/clock", or 0
  /// before the first sample. A simulated time may stand still or go back.
  std::chrono::sys_time<std::chrono::nanoseconds> now() const;

  /// Returns the state of discovery, UDP and shared memory, and counts of refused input (status.h).
  NodeStatus status() const;
  /// Returns all data of the node about its publishers, its subscribers and itself (snapshot.h); to_json()
  /// prints them.
  NodeSnapshot snapshot() const;

 private:
  template <class T, Req<T> R>
  static Result<detail::untyped::Requirement> requirement() {
    return detail::declared_selection<R>().map([](Selection&& selection) {
      return detail::untyped::Requirement{.selection = std::move(selection),
                                          .recorded = R.is_recorded,
                                          .fields_of_text = detail::fields_of_text<R>};
    });
  }

  explicit Node(std::shared_ptr<core::NodeCore> core) : core_(std::move(core)) {}
  Result<detail::untyped::Publisher> open_publisher(std::string_view topic, const TypeSupport& type,
                                                    const PublisherOptions& options);
  Result<detail::untyped::Subscriber> open_subscriber(std::string_view topic, const TypeSupport& type,
                                                      Result<detail::untyped::Requirement> requirement,
                                                      const SubscriberOptions& options,
                                                      detail::untyped::Callback callback);
  Result<DynamicSubscriber> open_subscriber(std::string_view topic, const DynamicType& type,
                                            detail::untyped::Requirement requirement,
                                            const SubscriberOptions& options,
                                            DynamicSubscriber::Callback callback);

  std::shared_ptr<core::NodeCore> core_;
  std::shared_ptr<core::SimulatedClock> clock_;  ///< null: now() is the system's time
};

}  // namespace sft
