// Samples in Python. Fields are attributes, and arrays refer to the memory of the sample.
#pragma once

#include <pybind11/numpy.h>

#include <atomic>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sft/dynamic.h"
#include "sft/strides.h"

namespace sft::python {

namespace py = pybind11;

/// A sample to which Python objects refer. Views and arrays share it, and it is released with the last of
/// them.
class HeldSample {
 public:
  /// The data that the samples of one subscriber share.
  struct Origin {
    Origin(std::string of_topic, bool records) : topic(std::move(of_topic)), is_recorded(records) {}

    const std::string topic;
    const bool is_recorded;
    std::atomic<int> held{0};  ///< the number of samples that the Python program holds
  };

  HeldSample(DynamicSample sample, std::shared_ptr<Origin> origin)
      : sample_(std::move(sample)), origin_(std::move(origin)) {
    ++origin_->held;
  }
  HeldSample(const HeldSample&) = delete;
  HeldSample& operator=(const HeldSample&) = delete;
  ~HeldSample() { --origin_->held; }

  const DynamicSample& sample() const { return sample_; }
  const std::string& topic() const { return origin_->topic; }
  bool is_recorded() const { return origin_->is_recorded; }

 private:
  const DynamicSample sample_;
  const std::shared_ptr<Origin> origin_;
};

/// A struct in a sample, or the whole sample.
class View {
 public:
  View(std::shared_ptr<const HeldSample> held, DynamicView view, std::string path)
      : held_(std::move(held)), view_(std::move(view)), path_(std::move(path)) {}

  const HeldSample& held() const { return *held_; }
  const StructType& type() const { return *view_.type(); }
  const DynamicView& view() const { return view_; }
  bool has(std::string_view member) const;
  /// Returns the value of a member: a number, a text, an array, a tuple, a View, or an sft.Absent.
  py::object member(std::string_view name) const { return value(view_[name], path_of(name)); }
  /// Returns the value at a path, such as "fields[0].name".
  py::object find(std::string_view path) const { return value(view_.find(path), path_of(path)); }
  /// Returns true if the sample was sent without the member. The call does not count as a read of the
  /// member.
  bool is_absent(std::string_view member) const { return view_[member].is_absent(); }
  py::object size(std::string_view path) const;
  /// Return the points of a cloud, as one structured array or as one array for each channel.
  py::object points(const std::vector<std::string>& names) const;
  py::object columns(const std::vector<std::string>& names) const;
  /// Returns the cells of a field as an array of bytes with the dimensions row, column and byte of the
  /// cell. Also returns whether the byte order of the values is swapped.
  py::object cells(const std::string& path, std::size_t cell_bytes) const;

 private:
  std::string path_of(std::string_view member) const;
  py::object value(const DynamicView& view, std::string path) const;
  py::object number_array(const DynamicView& view, const std::string& path) const;
  py::object elements(const DynamicView& view, const std::string& path) const;
  py::object absent(const std::string& path) const;
  /// Returns an sft.Absent if the field was not sent, and throws all other errors.
  py::object absent_or_throw(const Error& error, const std::string& path) const;
  Result<Strides> strides(std::vector<std::string>& names) const;
  py::array over(const Strides& strides, const py::dtype& type, std::size_t offset,
                 std::vector<py::ssize_t> inner, py::ssize_t inner_step) const;

  std::shared_ptr<const HeldSample> held_;
  DynamicView view_;
  std::string path_;  ///< the path of this struct in the sample; empty for the whole sample
};

/// A whole sample.
class Sample : public View {
 public:
  explicit Sample(const std::shared_ptr<const HeldSample>& held) : View(held, held->sample().view(), {}) {}
};

/// Returns a text of a message as a Python string. The text may be invalid UTF-8.
py::str text_of(std::string_view text);
/// Returns "sensor_msgs/PointCloud2" for "sensor_msgs::msg::PointCloud2".
std::string short_name(std::string_view name);
/// Adds the classes to the module.
void define_views(py::module_& module);

}  // namespace sft::python
