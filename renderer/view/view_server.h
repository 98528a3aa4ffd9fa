// Serves the page of a view and the requests that it makes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/view/gate.h"
#include "renderer/view/http_server.h"
#include "renderer/view/view_session.h"

#include <atomic>
#include <string>
#include <thread>

namespace kindling {

// Answers requests that passed a Gate. Targets, relative to the link:
//   GET  (nothing), FILE     the page and its files
//   GET  scene               what can be chosen, as JSON
//   GET  frame?after=V&image=I
//     Waits up to ten seconds for a version after V; status 204 if there is none. Four bytes, the
//     length of the header, little-endian; the header, JSON; the JPEG, unless it is image I.
//   GET  pixel?x=X&y=Y       values at a position, fractions of width and height
//   GET  save.png, save.exr  the image as a file
//   POST change              members of the state
class ViewRequests {
 public:
  // All references must outlive it.
  ViewRequests(ViewSession& session, const Gate& gate) : session_(session), gate_(gate) {}
  [[nodiscard]] HttpResponse answer(const HttpRequest& request) const;

 private:
  [[nodiscard]] HttpResponse frame(std::string_view query) const;

  ViewSession& session_;
  const Gate& gate_;
};

// Returns the value of a parameter of a query ("a=1&b=2") as a number from 0 to `max`, or nothing.
[[nodiscard]] std::optional<double> query_number(std::string_view query, std::string_view name, double max);

} // namespace kindling
