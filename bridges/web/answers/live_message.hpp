// The messages of the WebSocket (docs/web.md), as text. Any thread.
#pragma once

#include <string>
#include <string_view>

#include "bridges/web/answers/answer.hpp"

namespace slipd::web {

// {"type":"live","slipd":"ok","made_ms","sensors":[…],"grasps":[…]} from slipd's answer to `gamma`; made_ms
// is Answer::had_ms. Ages are the largest that they may be. An estimate older than max_age_ms, or without an
// age, is stale: it keeps an alert that was raised, and loses all that its frame said. A grasp is as old as
// its oldest sensor. Throws std::exception for an answer of another form.
std::string live_message(const Answer& gamma, double max_age_ms);

// The same while slipd is away; `why` is a sentence for people. The sensors and grasps are those of
// `last_live`, the last live_message (empty: there was none): disconnected, with the alerts that stand.
std::string away_message(std::string_view why, std::string_view last_live);

// {"type":"status","sensors":[…],"status":{…}} from slipd's answers. Throws as above.
std::string status_message(std::string_view sensors_answer, std::string_view status_answer);

// The first message: {"type":"hello","protocol":1,"version","max_age_ms"}.
std::string hello_message(std::string_view version, double max_age_ms);

}  // namespace slipd::web
