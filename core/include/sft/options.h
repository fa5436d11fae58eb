// How nodes, publishers and subscribers are set up: plain structs, which the function that opens one of them
// copies. Later changes to a struct have no effect. Settings that cannot work are an error of that function,
// which names the setting.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sft/event.h"
#include "sft/qos.h"

namespace sft {

/// The paths that samples may take. `automatic` is shared memory between processes of one host and UDP
/// between hosts, and UDP within a host while shared memory is not available.
enum class TransportChoice : std::uint8_t { automatic, shm, udp };

/// debug: the requests of subscribers, whenever they change. info: matches, their paths and the reasons.
/// warning: failures, and settings that can never work. error: functions that have ended and work again only
/// in a new node.
enum class LogLevel : std::uint8_t { debug, info, warning, error };

/// UDP of one node.
struct UdpSettings {
  /// Says when samples are sent once for several hosts. `automatic`: whenever that puts fewer bytes on the
  /// wire, but not on wireless interfaces (udp_transport/multicast/multicast.md). A switch without IGMP
  /// snooping passes multicast on to all hosts, and loads all their cables: choose `off` there.
  enum class Multicast : std::uint8_t { automatic, off };

  /// 0: any free port, and a second one for acknowledgements. A port that is given here is used for both.
  std::uint16_t port = 0;
  std::size_t receive_buffer_bytes = 32 * 1024 * 1024;  ///< requested from the kernel, which may grant less
  std::size_t memory_limit_bytes = 256 * 1024 * 1024;   ///< for all samples outside of shared memory
  bool use_io_uring = true;                             ///< false: plain sockets
  /// The most that the node sends by UDP, with the headers of SFT; 0: no limit. Small samples go first.
  /// Samples that no longer fit into a queue meanwhile are dropped, the oldest first, and counted.
  std::uint64_t max_bytes_per_s = 0;
  /// Multicast: readers on several hosts may be sent one copy together.
  Multicast multicast = Multicast::automatic;
};

/// Shared memory of one node, which the daemon sftd provides.
struct ShmSettings {
  bool start_daemon = true;  ///< true: start sftd if none is running
  /// The file of sftd. Empty: the one that $SFT_DAEMON names; otherwise the first one that is found beside
  /// the program, in ../libexec/sft from there, where SFT is installed, where it was built if it is a part of
  /// another project, and in PATH.
  std::string daemon_path{};
  /// A daemon that this node starts ends after no program has used it for so long; 0: never. A daemon that
  /// runs already, the one of a service for example, is not changed.
  std::chrono::seconds daemon_idle_exit = std::chrono::minutes(5);
  /// Users whose sftd is used, by name ("robot") or number, besides root, this program's own user, and the
  /// owner of the directory /run/sft. Such a user can read all samples in shared memory and end this program.
  /// The daemon of any other user is not used: samples go by UDP, and NodeStatus::shm says why. A user that
  /// one node accepts is accepted for all nodes of its process.
  std::vector<std::string> daemon_users{};
};

/// How nodes find each other. Nodes of one process may have different settings. Nodes with equal settings, an
/// equal NodeOptions::cyclonedds_config and equal NodeOptions::Threads::discovery share the threads of
/// Cyclone DDS.
struct DiscoverySettings {
  /// Hosts on which nodes are looked for, besides those that multicast reaches: "10.0.0.7", "robot.local", or
  /// with the port of one process, "10.0.0.7:7410". Both sides have to name each other. On each host the
  /// nodes of the first 20 processes are found; the interfaces of a host share this number.
  std::vector<std::string> peers{};
  /// Nodes are looked for and samples received only on these interfaces. An entry is a name ("eth0"), an
  /// address ("10.0.0.5", "fe80::1%eth0") or a network ("10.0.0.0/24", "fd00::/64"). Empty: all interfaces
  /// that are up, except bridges and cables of container engines (docker*, veth*, virbr*, br-* and the like)
  /// and interfaces without multicast. Interfaces that come later or get other addresses are used within 2 s,
  /// whether the list is empty or not. NodeStatus::discovery names those in use and those that are missing.
  /// Nodes of this host always find each other. Interfaces that CYCLONEDDS_URI names replace these.
  std::vector<std::string> interfaces{};
  /// False: nodes on other hosts are found only by `peers`. Nodes of this host always find each other.
  bool multicast = true;
};

/// Settings of some threads of a node. These threads never inherit a real-time policy or a CPU set from the
/// thread that opens the node: without settings they have the normal policy, and the CPUs that the program
/// was started with.
struct ThreadSettings {
  /// Says how the system chooses among threads that can run. `normal` is the default of the system
  /// (SCHED_OTHER). `fifo` and `round_robin` are the real-time policies SCHED_FIFO and SCHED_RR.
  enum class Policy : std::uint8_t { normal, fifo, round_robin };

  /// The numbers of the CPUs on which they may run. Empty: the CPUs that the program was started with.
  std::vector<unsigned> cpus{};
  Policy policy = Policy::normal;  ///< real-time policies need a right: see NodeOptions::Threads
  /// 1 (lowest) to 99 under a real-time policy, and 0 under the normal one.
  int priority = 0;
  /// The beginning of their names in /proc/PID/task/TID/comm: with "nav-" the thread "sft-udp-recv" is called
  /// "nav-udp-recv". The system keeps 15 characters of a name. Empty: "sft-", and no prefix for threads of
  /// Cyclone DDS.
  std::string name_prefix{};
  friend bool operator==(const ThreadSettings&, const ThreadSettings&) = default;
};

/// One node.
struct NodeOptions {
  /// The threads of a node, by their work. Node::open() fails if the system refuses one of these settings,
  /// and names it: real-time policies need CAP_SYS_NICE, or a limit RLIMIT_RTPRIO of at least the priority.
  struct Threads {
    /// Receives by UDP, and calls back for samples that came by UDP as long as callbacks are short.
    ThreadSettings receiver{};
    /// Sends by UDP what publish() did not send itself, and wakes the readers of this host if several sleep.
    ThreadSettings sender{};
    /// Negotiates.
    ThreadSettings agent{};
    /// Call back for samples in shared memory, for events and the log, and make file descriptors readable.
    ThreadSettings callbacks{};
    /// The threads of Cyclone DDS. Nodes of one process share them only if their settings here are equal. The
    /// settings hold only for the link of the loopback if the program itself opened the DDS domain.
    ThreadSettings discovery{};
  };

  /// Whether publishers also serve unmodified nodes of DDS and ROS 2 that read their topics (docs/ros2.md).
  /// `automatic`: while a node that is not one of SFT is heard, unless the program speaks DDS itself. A node
  /// on this host that was started before is heard within 8 s, and one that uses the loopback only is not
  /// heard. `always`: as long as the node has a publisher.
  enum class VanillaDds : std::uint8_t { automatic, always, never };

  /// A callback for lines of the log. It runs on a thread of the node for just that and for events (event.h),
  /// and may call any function of SFT. If several nodes have the same sink, a thread of each node calls it.
  /// A warning or an error that comes again is written after a pause, which grows from 5 s to 11 minutes. Of
  /// different lines of a kind about a topic, ten are written at once and then one in 5 s. The next line says
  /// how many were left out.
  using LogSink = std::function<void(LogLevel, std::string_view)>;

  /// DDS derives port numbers from the domain, and has none for a greater one.
  static constexpr std::uint32_t domain_max = 232;

  std::string name = "node";  ///< shown to people; several nodes may have the same name
  /// The namespace, with or without a slash in front: in "left" the topic "points" is "left/points", and the
  /// node "cam" is shown as "left/cam". Empty: none. Node (node.h) says which names are in it.
  std::string namespace_{};
  /// Remapping rules as `ros2 run ... -r` takes them, one in each text: "points:=front/points",
  /// "cam:points:=front" only for nodes with this name or full name ("/left/cam:points:=front"),
  /// "__node:=cam", "__ns:=/left". Names on both sides may be relative, absolute or private. The first rule
  /// that fits a name counts, and what it gives is not remapped again. The rules of the environment variable
  /// SFT_REMAP stand before these; blanks separate them. A warning of the log names each rule that has fitted
  /// nothing in the process 5 s after its last node opened, or when that closed.
  std::vector<std::string> remap{};
  /// True: Node::now() is the time of the topic "/clock" (rosgraph_msgs/Clock), as for nodes of ROS 2 with
  /// the parameter of this name. The node subscribes to it, with best effort and a depth of 1. Nothing else
  /// follows it: rates, conditions, deadlines, leases, timeouts and the stamps of SampleInfo count real time.
  /// A warning of the log says if nobody publishes the topic.
  bool use_sim_time = false;
  /// DDS domain of the control topics, 0 to domain_max. Default: $ROS_DOMAIN_ID, otherwise 0.
  std::optional<std::uint32_t> domain{};
  /// Default: that of $SFT_VANILLA_DDS (auto, always, never), otherwise automatic.
  std::optional<VanillaDds> vanilla_dds{};
  /// Settings by which nodes find each other.
  DiscoverySettings discovery{};
  TransportChoice transport = TransportChoice::automatic;  ///< limits all publishers and subscribers of it
  /// Settings of samples over UDP.
  UdpSettings udp{};
  /// Settings of samples in shared memory.
  ShmSettings shm{};
  /// CPUs, scheduling and names of the threads.
  Threads threads{};
  /// Configuration of Cyclone DDS, as XML or names of files. It takes precedence over the settings of SFT,
  /// except for those without which SFT cannot work; the log and NodeStatus::discovery name the latter.
  /// Default: $CYCLONEDDS_URI.
  std::optional<std::string> cyclonedds_config{};
  /// Gets the log. Without it the log goes to the standard error of the process, and the library prints
  /// nothing else. Cyclone DDS prints nothing in a process with a node: its messages have one destination in
  /// a process, and are kept for the errors that they explain.
  LogSink log{};
  /// Lines below this level are not even made. Default: info with `log`, warning without. Without `log` the
  /// environment variable SFT_LOG takes precedence: off, error, warning, info or debug.
  std::optional<LogLevel> log_level{};
};

struct PublisherStatus;

/// One publisher. A duration of 0 means none: no deadline, no end of the lifespan, no lease. Deadlines and
/// leases are at least 1 ms.
struct PublisherOptions {
  TransportChoice transport = TransportChoice::automatic;  ///< the paths that samples may go by
  Reliability reliability = Reliability::best_effort;      ///< qos.h explains it
  Durability durability =
      Durability::volatile_;  ///< transient_local: late subscribers get the last samples, too
  /// Number of samples that are kept for late subscribers if durability is transient_local, 1 to 128. They
  /// occupy their memory, in shared memory, too, and are encoded with all fields, whatever is asked for.
  std::uint32_t history_depth = 1;
  /// The publisher promises a sample at least so often, and gets an event if it fails.
  std::chrono::nanoseconds deadline{0};
  /// A sample that was published longer ago is not delivered any more. Clocks of two hosts may differ, and
  /// the time with them.
  std::chrono::nanoseconds lifespan{0};
  Liveliness liveliness =
      Liveliness::automatic;  ///< who says that the publisher is alive: its node or the program
  std::chrono::nanoseconds liveliness_lease{0};  ///< the publisher promises a sign of life at least so often
  /// The longest time, up to 1 s, that publish() waits for reliable subscribers that do not keep up, on this
  /// host and on others, before they lose their oldest sample (DDS: max_blocking_time). In shared memory
  /// publish() waits for room in their queues, and for a free chunk if a subscriber must not use UDP. Over
  /// UDP it waits for acknowledgements of the samples that it keeps for them, and, at most 10 ms of the time,
  /// if it is ahead of the network by more than 8 MB. publish(span) waits no longer in all than publish() of
  /// one sample. It never waits for best-effort subscribers. The default is not to wait: a subscriber that
  /// hangs would delay the program at each publish(), and with it all other subscribers.
  std::chrono::nanoseconds max_blocking{0};
  /// The largest encoded message, up to 64 MiB. It is announced, and subscribers set aside no more memory
  /// than that. A sample that is larger than the largest chunk of shared memory (which depends on the size of
  /// /dev/shm, see "When memory runs short" in docs/operations.md) goes by UDP within the host, like one for
  /// which no chunk is free. Samples of more than 16 MiB take much of UdpSettings::memory_limit_bytes, on
  /// both sides.
  std::size_t max_sample_bytes = 64 * 1024 * 1024;
  /// The most that is sent by UDP, over all masks and readers; 0: no limit. Small samples go first. Samples
  /// that no longer fit into a queue meanwhile are dropped, the oldest first, and counted.
  std::uint64_t max_bytes_per_s = 0;
  /// True: publish() copies a sample of more than 16 KiB for readers on other hosts and returns; a thread of
  /// the node sends it. False: publish() itself sends it to one process at least, and copies nothing, so that
  /// it arrives earlier. The option changes nothing where max_blocking is not 0.
  bool asynchronous = false;
  /// Called after readers came, left or changed what they ask for, once that is in force, with the status of
  /// all of them. (on_event tells what happened to each.) It runs on the thread for events (event.h). Like
  /// any callback it may be called before the function that opens the publisher has returned. It may publish,
  /// if no other thread does so at the same time.
  std::function<void(const PublisherStatus&)> on_readers_changed{};
  Event::Callback on_event{};  ///< called with what happens to its pairs, on the node's thread for events
};

/// One subscriber. A duration of 0 means none: any deadline and any liveliness fit. Others are at least 1 ms.
struct SubscriberOptions {
  /// Subscribers whose fields are recorded. A sample counts when it is released.
  struct Recording {
    /// The subscriber asks for all fields at first, and after so many samples for those that were read; at
    /// least 1.
    std::uint32_t learn_samples = 3;
    /// A field that was not read in so many samples in a row is not asked for any more; 0: once asked for, it
    /// always is. A field that is read at least once in so many samples is never given up.
    std::uint32_t narrow_after_samples = 100;
    /// True: samples from shared memory have only the fields that were asked for when they were taken, as
    /// they would on another host. A program can so be tried on one host before it runs on two. Whole
    /// fields are copied for that; parts of fields stay where they are. This also applies to a subscriber
    /// whose fields are not recorded.
    bool as_remote = false;
  };

  TransportChoice transport = TransportChoice::automatic;  ///< the paths that samples may come by
  Reliability reliability = Reliability::best_effort;      ///< reliable matches reliable publishers only
  Durability durability = Durability::volatile_;  ///< transient_local: asks for the last samples from before,
                                                  ///< and for a publisher that retains them
  /// Number of samples of each publisher that are kept until they are taken, 1 to 1,000,000. Beyond it the
  /// oldest are lost, and counted. Shared memory keeps at most 256; if a subscriber that may use it asks for
  /// more, the log says so, and SubscriberStatus::Writer::depth tells the number in force. Of all publishers
  /// that are gone together no more than this number is kept.
  std::uint32_t depth = 8;
  /// The bytes of samples of each publisher that are kept until they are taken; 0: no limit but `depth`.
  /// Beyond it the oldest are lost, too, but the newest one always stays. So a subscriber that is slow, or
  /// does not take at all, leaves the memory that large samples need to the others. In shared memory the
  /// number is rounded down to a power of two of 64 KiB or more.
  std::size_t depth_bytes = 32 * 1024 * 1024;
  std::chrono::nanoseconds deadline{0};  ///< it expects a sample from each publisher at least so often
  Liveliness liveliness = Liveliness::automatic;  ///< manual_by_topic matches publishers of that kind only
  std::chrono::nanoseconds liveliness_lease{0};   ///< it expects a sign of life at least so often
  /// The most samples per second of each selection, evenly spaced, from slowest_rate_hz to fastest_rate_hz;
  /// 0: all. Other samples are withheld: they are not sent, and are counted apart from lost ones.
  /// Subscriber::set_max_rate_hz() changes the rate.
  double max_rate_hz = 0;
  /// Says which parts of the declared fields are needed, and when a sample is: "data{x,y,z}[::4]", "@
  /// percentage > 20 or every 10 s", or both (TypeSupport::parse_selection()). Fields that it does not name
  /// are sent as they are declared. If fields are recorded, it may have conditions only. Empty: whole fields
  /// of every sample. Subscriber::set_selection() changes it. For a subscriber with sft::selected it names
  /// the fields, too: "header.stamp, data{x,y,z}". If it names none, these are all fields. Not for
  /// subscribers of types that the program was not compiled with, which are opened with such a text.
  std::string selection{};
  /// Further selections, as texts of the same kind: "pose.pose @ at most 100 Hz" as the first selection, and
  /// "pose.covariance @ at most 1 Hz" here. A message comes once by each selection that lets it through.
  /// SampleInfo::selection says by which one a sample came: 0 is the first selection, 1 the first of these.
  /// The oldest of all samples that have come is delivered first. The samples of one message are delivered in
  /// the order of the selections, if all have come. A sample may have more fields than its selection asks
  /// for, since one encoding may serve several selections, and a sample in shared memory has all.
  ///
  /// To publishers and tools each selection is a subscriber of its own, which matches and connects alone:
  /// Publisher::wait_for_subscribers() counts each, and all limits do, too. Each selection has counts of its
  /// own. `depth`, `max_held` and `max_rate_hz` are for each selection; a `deadline` is for the first one
  /// only. An error if fields are recorded.
  std::vector<std::string> further_selections{};
  static constexpr std::size_t selections_max = 16;    ///< of a subscriber, with the first one
  static constexpr double slowest_rate_hz = 0.001;     ///< the least max_rate_hz but 0
  static constexpr double fastest_rate_hz = 100'000;   ///< the greatest max_rate_hz
  static constexpr std::uint32_t max_held_least = 2;   ///< one is held while the next is taken
  static constexpr std::uint32_t max_held_most = 256;  ///< iceoryx holds no more
  /// Number of samples in shared memory of one publisher that the program may hold at the same time. While it
  /// holds that many, take() gives no more of that publisher; its next samples wait within
  /// `depth`. A sample with parts of fields holds the whole sample that they lie in. The subscriber gets one
  /// event each time (Event::Kind::held_too_many). Others are not affected.
  std::uint32_t max_held = max_held_most;
  /// How long wait() spins, which keeps a core busy, before it sleeps. A sample that comes within that time
  /// is taken within a microsecond, because no thread has to be woken. The default is about the time that it
  /// takes to wake a thread, so that spinning never costs more than it can save. Threads that wait for the
  /// core get it meanwhile. After a wait that ended without a sample, or took more than ten times as long as
  /// this, the next one sleeps at once. For a reader with a core of its own choose more than the period of
  /// the samples. With a callback, the thread that receives by UDP spins so long (1 s at most), as long as
  /// datagrams come about as often. It has no effect on a subscriber that is pollable.
  std::chrono::nanoseconds spin = std::chrono::microseconds(20);
  /// True: the subscriber has a Subscriber::file_descriptor(), and its node a thread that makes it readable
  /// for samples in shared memory. Not together with a callback.
  bool pollable = false;
  Recording recording{};       ///< how fields are found out where they are recorded
  Event::Callback on_event{};  ///< called with what happens to its pairs, on the node's thread for events
};

}  // namespace sft
