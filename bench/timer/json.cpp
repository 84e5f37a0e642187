#include "json.h"

#include <cmath>
#include <cstdio>
#include <ostream>

namespace isimp::bench {
namespace {

struct Printer {
  std::ostream& out;

  void operator()(bool v) const { out << (v ? "true" : "false"); }
  void operator()(double v) const {
    char text[32];
    std::snprintf(text, sizeof text, v == std::floor(v) && std::abs(v) < 1e15 ? "%.0f" : "%.7g", v);
    out << (std::isfinite(v) ? text : "null");
  }
  void operator()(const std::string& v) const {
    out << '"';
    for (const char c : v) {
      if (c == '"' || c == '\\') out << '\\';
      if (static_cast<unsigned char>(c) >= 0x20) out << c;
    }
    out << '"';
  }
  void operator()(const Json::List& v) const {
    out << '[';
    for (std::size_t i = 0; i < v.size(); ++i) out << (i ? ", " : "") << v[i];
    out << ']';
  }
  void operator()(const Json::Object& v) const {
    out << '{';
    bool first = true;
    for (const auto& [key, member] : v) {
      out << (first ? "" : ",\n");
      (*this)(key);
      out << ": " << member;
      first = false;
    }
    out << '}';
  }
};

}  // namespace

std::ostream& operator<<(std::ostream& out, const Json& json) {
  std::visit(Printer{out}, json.value_);
  return out;
}

}  // namespace isimp::bench
