#pragma once

#include <concepts>
#include <iosfwd>
#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace isimp::bench {

/// A value that can be printed as JSON: number, text, truth, list, or object with its keys in alphabetical order.
class Json {
 public:
  using List = std::vector<Json>;
  using Object = std::map<std::string, Json>;

  Json() : value_(Object{}) {}
  Json(bool v) : value_(v) {}
  template <class T>
  requires(std::integral<T> || std::floating_point<T>) Json(T v) : value_(static_cast<double>(v)) {}
  Json(const char* v) : value_(std::string(v)) {}
  Json(std::string v) : value_(std::move(v)) {}
  Json(List v) : value_(std::move(v)) {}
  Json(Object v) : value_(std::move(v)) {}
  Json(const std::vector<double>& v) : value_(List(v.begin(), v.end())) {}

  /// A member of an object, made if there is none.
  Json& operator[](const std::string& key) { return std::get<Object>(value_)[key]; }

  friend std::ostream& operator<<(std::ostream& out, const Json& json);

 private:
  std::variant<bool, double, std::string, List, Object> value_;
};

}  // namespace isimp::bench
