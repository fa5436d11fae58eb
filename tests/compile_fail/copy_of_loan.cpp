// expect: (use of deleted function .*Loan|call to (implicitly-deleted|deleted)? ?copy constructor)
#include "tests/compile_fail/cloud.h"

auto misuse(sft::Loan<PointCloud2>& loan) {
  sft::Loan<PointCloud2> second = loan;
  return std::move(second).publish();
}
