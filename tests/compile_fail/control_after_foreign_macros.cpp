// All public and generated headers compile after the macros of Qt, X11, Windows and common -D options were
// defined.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <concepts>
#include <filesystem>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <ranges>
#include <span>
#include <sstream>
#include <string>
#include <thread>
#include <tl/expected.hpp>
#include <variant>
#include <vector>

// macros of Qt
#define slots
#define signals public
#define emit
#define foreach for
#define forever for (;;)
// macros of X11
#define Above 0
#define Always 2
#define Below 1
#define Bool int
#define Complex 0
#define Convex 2
#define CursorShape 0
#define Expose 12
#define False 0
#define FocusIn 9
#define GrayScale 1
#define KeyPress 2
#define Never 0
#define None 0L
#define Status int
#define Success 0
#define True 1
#define Unsorted 0
// macros of Windows
#define CONST const
#define CreateEvent CreateEventA
#define DELETE 0x10000L
#define ERROR 0
#define FALSE 0
#define GetMessage GetMessageA
#define IN
#define INFINITE 0xffffffff
#define NO_ERROR 0L
#define OPTIONAL
#define OUT
#define TRANSPARENT 1
#define TRUE 1
#define VOID void
#define Yield()
#define far
#define interface struct
#define max(a, b) (((a) > (b)) ? (a) : (b))
#define min(a, b) (((a) < (b)) ? (a) : (b))
#define near
#define small char
// macros of common -D options
#define DEBUG 1
#define FATAL 1
#define INFO 1
#define OK 0
#define STATUS 1
#define TRACE 1
#define UNKNOWN 0
#define VERSION 1
#define WARN 1
#define check(x) (x)
#define require(x) (x)
#define verify(x) (x)

#include <sft/sft.h>

#include <diagnostic_msgs/msg/DiagnosticStatus.hpp>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <rcl_interfaces/msg/Log.hpp>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/JoyFeedback.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/NavSatFix.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <sensor_msgs/msg/Range.hpp>
#include <shape_msgs/msg/SolidPrimitive.hpp>
#include <std_msgs/msg/Bool.hpp>
#include <tf2_msgs/msg/TF2Error.hpp>
#include <visualization_msgs/msg/InteractiveMarkerUpdate.hpp>
#include <visualization_msgs/msg/Marker.hpp>

// The macros have their former values again behind each header.
static_assert(DEBUG == 1 && TRUE == 1 && UNKNOWN == 0);
Bool is_defined = True;
