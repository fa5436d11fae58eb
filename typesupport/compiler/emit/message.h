// A struct of the model with the C++ names of all that is in it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "model.h"

namespace sft::idl {

struct Field {
  const sft_member* idl;
  std::string name;
};

struct Constant {
  const sft_declaration* idl;
  std::string name;
};

/// Refers to the model and must not outlive it.
struct Message {
  std::string_view idl_name;  ///< "sensor_msgs::msg::PointCloud2"
  std::string name;           ///< in C++, "PointCloud2"
  std::string qualified;      ///< in C++, "::sensor_msgs::msg::PointCloud2"
  std::vector<Constant> constants;
  std::vector<Field> fields;

  /// How a nested class's definition at global scope names this class: C++ allows no "::" in front there.
  std::string_view class_head() const { return std::string_view(qualified).substr(2); }
};

/// `declaration` is a struct of `file`. Its constants are those that the file declares, as ROS does, in a
/// module X_Constants beside the struct X.
Message make_message(const sft_file& file, const sft_declaration& declaration);

/// Whether a constant is one of a struct of this file, and so not one of its namespace.
bool belongs_to_struct(const sft_file& file, const sft_declaration& constant);

/// Whether a loan can reserve the field, to be written in place: sequences of primitives and enumerations.
bool is_reservable(const Field& field);

/// Whether LoanSizes and LoanView name the field: that, or a struct, in which there may be such.
bool has_loan_size(const Field& field);

}  // namespace sft::idl
