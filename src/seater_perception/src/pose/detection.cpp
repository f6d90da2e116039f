#include "seater_perception/detection.h"

#include "pose/pose.h"

namespace seater_perception {

const char* nameOf(PoseStage stage) {
  switch (stage) {
    case PoseStage::photometric:
      return "photometric";
    case PoseStage::edges:
      return "edges";
    case PoseStage::corners:
      break;
  }
  return "corners";
}
namespace {

template <typename Hypothesis>
Matrix6d mixture(const std::vector<Hypothesis>& hypotheses) {
  Matrix6d covariance = Matrix6d::Zero();
  for (const PoseHypothesis& h : hypotheses) {
    const auto d = poseDifference(hypotheses.front().pose, h.pose);
    covariance += h.weight * (h.covariance + d * d.transpose());
  }
  return covariance;
}

}  // namespace

Matrix6d mixtureCovariance(const std::vector<PoseHypothesis>& hypotheses) {
  return mixture(hypotheses);
}

Matrix6d mixtureCovariance(const std::vector<DockHypothesis>& hypotheses) {
  return mixture(hypotheses);
}

}  // namespace seater_perception
