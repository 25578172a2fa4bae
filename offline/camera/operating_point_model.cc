#include "camera/operating_point_model.h"

#include <fmt/format.h>

#include <numeric>
#include <utility>

namespace raygrid {
namespace {

// Adds factor * term to a surface.
void AddTerm(double factor, const BSplineSurface& term,
             BSplineSurface* surface) {
  for (int k = 0; k < surface->num_points(); ++k)
    surface->points()[k] += factor * term.points()[k];
}

}  // namespace

std::string OperatingParameterName(OperatingParameter condition) {
  return condition == OperatingParameter::kLensPosition ? "lens_position"
                                                        : "temperature";
}

std::string OperatingParameterUnit(OperatingParameter condition) {
  return condition == OperatingParameter::kLensPosition ? "dioptres" : "°C";
}

std::optional<OperatingParameter> FindOperatingParameter(
    const std::string& name) {
  for (const OperatingParameter condition :
       {OperatingParameter::kLensPosition, OperatingParameter::kTemperature})
    if (name == OperatingParameterName(condition)) return condition;
  return std::nullopt;
}

std::vector<double> OperatingRange::SampleValues(int count) const {
  std::vector<double> values;
  for (int k = 0; k < count; ++k)
    values.push_back(low + (high - low) * k / (count - 1));
  values.back() = high;
  return values;
}

std::string OperatingRange::Text() const {
  return fmt::format("{:g} to {:g} {}", low, high,
                     OperatingParameterUnit(condition));
}

OperatingPointModel::OperatingPointModel(std::vector<OperatingRange> ranges,
                                         std::vector<int> orders,
                                         const CentralGeneric& camera)
    : ranges_(std::move(ranges)),
      orders_(std::move(orders)),
      image_size_(camera.image_size()),
      terms_({camera.surface()}) {
  const BSplineSurface& surface = camera.surface();
  terms_.resize(
      1 + std::accumulate(orders_.begin(), orders_.end(), 0),
      BSplineSurface(surface.area(), surface.columns(), surface.rows()));
}

OperatingPoint OperatingPointModel::Center() const {
  OperatingPoint center;
  for (const OperatingRange& range : ranges_) center.push_back(range.Center());
  return center;
}

int OperatingPointModel::FirstTerm(size_t range) const {
  return std::accumulate(
      orders_.begin(), orders_.begin() + static_cast<std::ptrdiff_t>(range), 1);
}

std::vector<double> OperatingPointModel::EvaluateBasis(
    const OperatingPoint& values) const {
  std::vector<double> factors = {1};
  for (size_t r = 0; r < ranges_.size(); ++r) {
    const OperatingRange& range = ranges_[r];
    const double t =
        (values[r] - range.Center()) / ((range.high - range.low) / 2);
    double power = 1;
    for (int j = 0; j < orders_[r]; ++j) factors.push_back(power *= t);
  }
  return factors;
}

CentralGeneric OperatingPointModel::At(const OperatingPoint& values) const {
  const std::vector<double> factors = EvaluateBasis(values);
  BSplineSurface surface = terms_.front();
  for (size_t j = 1; j < terms_.size(); ++j)
    AddTerm(factors[j], terms_[j], &surface);
  return CentralGeneric(image_size_, std::move(surface));
}

OperatingPointModel OperatingPointModel::FixValues(
    const FixedOperatingPoint& at) const {
  OperatingPoint values = Center();
  OperatingPointModel rest = *this;
  rest.ranges_.clear();
  rest.orders_.clear();
  rest.terms_ = {terms_.front()};
  for (size_t r = 0; r < ranges_.size(); ++r)
    if (at[r]) values[r] = *at[r];
  const std::vector<double> factors = EvaluateBasis(values);
  for (size_t r = 0; r < ranges_.size(); ++r) {
    const int first = FirstTerm(r);
    for (int j = first; j < first + orders_[r]; ++j) {
      if (at[r])
        AddTerm(factors[j], terms_[j], &rest.terms_.front());
      else
        rest.terms_.push_back(terms_[j]);
    }
    if (at[r]) continue;
    rest.ranges_.push_back(ranges_[r]);
    rest.orders_.push_back(orders_[r]);
  }
  return rest;
}

OperatingPointModel OperatingPointModel::SliceAlong(size_t range) const {
  FixedOperatingPoint at;
  for (const OperatingRange& other : ranges_) at.emplace_back(other.Center());
  at[range].reset();
  return FixValues(at);
}

OperatingPointModel OperatingPointModel::AddOrder(size_t range) const {
  OperatingPointModel more = *this;
  const BSplineSurface& surface = terms_.front();
  more.terms_.emplace(more.terms_.begin() + FirstTerm(range) + orders_[range],
                      surface.area(), surface.columns(), surface.rows());
  ++more.orders_[range];
  return more;
}

}  // namespace raygrid
