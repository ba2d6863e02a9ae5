// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/progress.h"
#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/parallel.h"
#include "panoptic/predict/prediction_io.h"
#include "panoptic/predictor.h"
#include "panoptic/simulation.h"

namespace panoptic {

void tell_warnings(Predictor* predictor) {
  if (predictor == nullptr) return;
  for (const std::string& warning : predictor->take_warnings()) tell(fmt::format("\nwarning: {}\n", warning));
}

PredictorReport closing_report(Predictor* predictor) {
  tell_warnings(predictor);
  PredictorReport report = predictor != nullptr ? predictor->report() : PredictorReport();
  for (const std::string& note : report.notes) fmt::print("note: {}\n", note);
  return report;
}

int predict(const Arguments& arguments) {
  const FrameRange range = frame_range_from(arguments);
  Options options = options_from(arguments);
  options.predictions.clear();  // a file of options may hold them for run
  if (options.networks.semantic.empty() && options.networks.instance.empty()) {
    throw UsageError("predict needs --semantic, --instance or both");
  }
  set_thread_count(arguments.threads);
  require_writable_folder(arguments.output);
  const auto dataset = open_checked(arguments);
  const auto predictor = make_predictor(options);
  PredictionWriter writer(arguments.output, predictor->labels(), networks_text(options.networks));

  watch_for_interrupt();
  std::size_t written = 0;
  std::size_t skipped = 0;
  bool saw_something = false;
  {
    FrameStream stream(*dataset, range);
    Progress progress("frames", range.count(dataset->size()));
    for (auto read = stream.next(); read && !interrupted(); read = stream.next()) {
      if (read->frame && check(*read->frame).used) {
        const Segmentation segmentation = predictor->predict(*read->frame);
        saw_something = saw_something || !segmentation.segments.empty();
        writer.write(read->frame->index, segmentation);
        written++;
      } else {
        skipped++;
      }
      tell_warnings(predictor.get());
      progress.advance(written + skipped);
    }
  }
  fmt::print("{} predictions in {}, {} frames skipped\n", written, arguments.output, skipped);
  const PredictorReport report = closing_report(predictor.get());
  if (interrupted()) return kInterrupted;
  if (written == 0) {
    throw Error(fmt::format("{}: no frame was usable, so there are no predictions; panoptic doctor says why", arguments.dataset));
  }
  if (!report.trouble.empty()) throw Error(fmt::format("{} (the predictions are in {})", report.trouble, arguments.output));
  if (!saw_something) {
    throw Error(fmt::format("{}: not one label in {} predictions ({}); do the networks fit their descriptions and the label set?",
                            networks_text(options.networks), written, arguments.output));
  }
  return kDone;
}

}  // namespace panoptic
