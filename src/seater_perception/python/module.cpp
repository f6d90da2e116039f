// Python module seater_perception: the library that the nodelet runs, for evaluation and tools. Long calls let other
// threads run. Poses are 4x4 matrices, images (height, width) arrays of uint8 or uint16, points (n, 2) or (n, 3).

#include "conversions.h"
#include "describe.h"
#include "seater_perception/dock_detector.h"
#include "seater_perception/dock_tracker.h"
#include "seater_perception/errors.h"
#include "seater_perception/photometric.h"
#include "seater_perception/report.h"

namespace sp = seater_perception;
namespace py = pybind11;
using namespace pybind11::literals;
using seater_python::asDict;
using seater_python::asMat;
using seater_python::OneAtATime;
using seater_python::yaml;

namespace {

Eigen::MatrixXd cornersOf(const sp::DetectedMarker& marker) {
  Eigen::MatrixXd corners(4, 2);
  for (int i = 0; i < 4; ++i) corners.row(i) = marker.corners[static_cast<std::size_t>(i)].transpose();
  return corners;
}

Eigen::MatrixXd project(const sp::CameraModel& camera, const Eigen::Matrix<double, Eigen::Dynamic, 3>& points) {
  Eigen::MatrixXd pixels(points.rows(), 2);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const auto pixel = camera.project(points.row(i).transpose());
    pixels.row(i) = pixel.value_or(Eigen::Vector2d::Constant(std::nan(""))).transpose();
  }
  return pixels;
}

sp::PerceptionParameters parametersOf(const py::dict& values) {
  return sp::loadPerceptionParameters(yaml(values), "perception");
}

const char* const kMount = "`mount`: the mapping `camera` of config/chair.yaml; None: its defaults";

sp::CameraMount mountOf(const py::object& values) {
  return values.is_none() ? sp::CameraMount() : sp::loadCameraMount(yaml(values), "camera");
}

void bindConfiguration(py::module_& m) {
  py::class_<sp::Calibration>(m, "Calibration", "As sensor_msgs/CameraInfo holds it; nothing is checked here.")
      .def(py::init([](int width, int height, const std::array<double, 9>& K, const std::vector<double>& D,
                       const std::string& distortion_model, const std::array<double, 12>& P) {
             return sp::Calibration{width, height, K, D, distortion_model, P};
           }),
           "width"_a, "height"_a, "K"_a, "D"_a, "distortion_model"_a = "plumb_bob", "P"_a = std::array<double, 12>{})
      .def_readonly("width", &sp::Calibration::width)
      .def_readonly("height", &sp::Calibration::height);
  m.def("load_calibration", &sp::loadCalibration, "path"_a, "Reads a file of camera_calibration.");
  py::class_<sp::CameraModel>(m, "CameraModel", "Pinhole camera; a pixel's centre has integer coordinates.")
      .def_static("raw", &sp::CameraModel::raw, "calibration"_a)
      .def_static("rectified", &sp::CameraModel::rectified, "calibration"_a)
      .def("project", &project, "points"_a, "(n, 3) [m] in the optical frame -> (n, 2) [px]; NaN behind the camera")
      .def_property_readonly("width", &sp::CameraModel::width)
      .def_property_readonly("height", &sp::CameraModel::height);
  py::class_<sp::DockLayout>(m, "DockLayout", "Marker family, sizes and places.")
      .def_readonly("family", &sp::DockLayout::family);
  m.def(
      "load_dock_layout", [](const py::dict& dock) { return sp::loadDockLayout(yaml(dock), "dock"); }, "dock"_a,
      "Of the mapping of a dock file; these markers are known to stand upright.");
  const char* const equal = "Every marker of the family has this side [m]; nothing is known of how they stand.";
  m.def("layout_of_equal_markers", py::overload_cast<const sp::MarkerFamily&, double>(&sp::layoutOfEqualMarkers),
        "family"_a, "size"_a, equal);
  m.def("layout_of_equal_markers", py::overload_cast<const std::string&, double>(&sp::layoutOfEqualMarkers),
        "dictionary"_a, "size"_a, equal);
  m.def(
      "default_parameters", [] { return asDict(sp::PerceptionParameters()); }, "As in config/perception.yaml.");
  m.def("default_photometric_parameters", [] { return asDict(sp::PhotometricParameters()); });
  m.def(
      "describe_parameters", [] { return seater_python::described(sp::PerceptionParameters()); },
      "A dict for each key of config/perception.yaml: key, default, unit, low, high, choices, text.");
}

void bindResults(py::module_& m) {
  py::class_<sp::PoseHypothesis>(m, "PoseHypothesis", "One possible pose in the optical frame.")
      .def_property_readonly("pose", [](const sp::PoseHypothesis& h) { return Eigen::Matrix4d(h.pose.matrix()); })
      .def_readonly("covariance", &sp::PoseHypothesis::covariance,
                    "6x6, x y z [m], rotation [rad]; t_true = t + d, R_true = exp([w]x) R")
      .def_readonly("error", &sp::PoseHypothesis::error, "rms reprojection error [px]")
      .def_readonly("weight", &sp::PoseHypothesis::weight);
  py::class_<sp::DockHypothesis, sp::PoseHypothesis>(m, "DockHypothesis")
      .def_readonly("marker_ids", &sp::DockHypothesis::marker_ids);
  py::class_<sp::DetectedMarker>(m, "DetectedMarker")
      .def_property_readonly("id", [](const sp::DetectedMarker& marker) { return marker.id; })
      .def_property_readonly("corners", [](const sp::DetectedMarker& marker) { return cornersOf(marker); })
      .def_readonly("size", &sp::DetectedMarker::size)
      .def_property_readonly(
          "stage", [](const sp::DetectedMarker& marker) { return sp::nameOf(marker.stage); },
          "what the pose was fitted to: corners, edges or photometric")
      .def_readonly("white_cut_off", &sp::DetectedMarker::white_cut_off,
                    "part of the white in and round it that is at the end of the range: over-exposed")
      .def_readonly("ambiguity", &sp::DetectedMarker::ambiguity,
                    "likelihood of the second hypothesis over that of the first, by the image alone; 0: no second one")
      .def_readonly("hypotheses", &sp::DetectedMarker::hypotheses)
      .def_property_readonly("covariance", [](const sp::DetectedMarker& marker) { return marker.covariance(); });
  py::class_<sp::DetectionResult>(m, "DetectionResult")
      .def_readonly("markers", &sp::DetectionResult::markers)
      .def_readonly("dock", &sp::DetectionResult::dock)
      .def_readonly("refused", &sp::DetectionResult::refused);
  py::class_<sp::FocalCheck>(m, "FocalCheck")
      .def_readonly("excess", &sp::FocalCheck::excess, "of the calibration's focal length, over that which fits best")
      .def_readonly("sigma", &sp::FocalCheck::sigma, "standard deviation of it")
      .def_property_readonly("contradicts", &sp::FocalCheck::contradicts);
  m.def("check_focal_length", &sp::checkFocalLength, "camera"_a, "layout"_a, "result"_a, "placement_sigma"_a = 0.0005,
        "By the markers of the dock in one image; None where they do not tell.");
}

void bindDetector(py::module_& m) {
  using Detector = OneAtATime<sp::DockDetector>;
  py::class_<Detector>(
      m, "DockDetector",
      "Image in, markers and dock out. Threads that share one wait for each other: use one per thread.")
      .def(py::init([](const sp::CameraModel& camera, const sp::DockLayout& layout, const py::dict& parameters,
                       const py::object& mount) {
             return std::make_unique<Detector>(camera, layout, parametersOf(parameters), mountOf(mount));
           }),
           "camera"_a, "layout"_a, "parameters"_a, "mount"_a = py::none(), kMount)
      .def(
          "detect",
          [](Detector& self, const py::array& image) {
            const cv::Mat grey = asMat(image);
            return self.call([&](sp::DockDetector& detector) { return detector.detect(grey); });
          },
          "image"_a);
  using Tracker = OneAtATime<sp::DockTracker>;
  py::class_<Tracker>(m, "DockTracker", "The same for a sequence of images.")
      .def(py::init([](const sp::CameraModel& camera, const sp::DockLayout& layout, const py::dict& parameters,
                       const py::object& mount) {
             return std::make_unique<Tracker>(camera, layout, parametersOf(parameters), mountOf(mount));
           }),
           "camera"_a, "layout"_a, "parameters"_a, "mount"_a = py::none(), kMount)
      .def(
          "detect",
          [](Tracker& self, const py::array& image) {
            const cv::Mat grey = asMat(image);
            return self.call([&](sp::DockTracker& tracker) { return tracker.detect(grey); });
          },
          "image"_a)
      .def(
          "reset", [](Tracker& self) { self.call([](sp::DockTracker& tracker) { tracker.reset(); }); },
          "The next image is searched as a whole.");
}

void bindMarkers(py::module_& m) {
  py::class_<sp::MarkerPattern>(m, "MarkerPattern", "The cells of a print.")
      .def_static("from_cells", &sp::MarkerPattern::fromCells, "rows_from_top"_a)
      .def_property_readonly("cells", &sp::MarkerPattern::cells)
      .def("at", &sp::MarkerPattern::at, "column"_a, "row"_a);
  py::class_<sp::MarkerFamily>(m, "MarkerFamily", "Codes of a family of markers (config/marker_families/README.md).")
      .def(py::init<const std::string&, const std::vector<sp::MarkerCode>&, int, int>(), "name"_a, "codes"_a,
           "border"_a = 1, "correctable_bits"_a = 0, "`codes`: for each id its bits, row by row from the top, 1 white")
      .def_static("named", &sp::MarkerFamily::named, "name"_a, "key"_a = "dictionary")
      .def_static("load", &sp::MarkerFamily::load, "path"_a)
      .def_static("names", &sp::MarkerFamily::names)
      .def_property_readonly("name", &sp::MarkerFamily::name)
      .def_property_readonly("bits", &sp::MarkerFamily::bits, "along a side of the code")
      .def_property_readonly("border", &sp::MarkerFamily::border, "[cells]")
      .def_property_readonly("cells", &sp::MarkerFamily::cells, "along a side of the black square")
      .def_property_readonly("correctable_bits", &sp::MarkerFamily::correctableBits)
      .def("__len__", &sp::MarkerFamily::count)
      .def("code", &sp::MarkerFamily::code, "id"_a, "rows from the top, 1 white")
      .def("pattern", &sp::MarkerFamily::pattern, "id"_a);
}

void bindPhotometric(py::module_& m) {
  py::class_<sp::PatternPlacement>(m, "PatternPlacement", "A print and where it sits on the object.")
      .def(py::init([](const sp::MarkerPattern& pattern, double size, const Eigen::Matrix4d& T) {
             return sp::PatternPlacement{pattern, size, seater_python::pose(T)};
           }),
           "pattern"_a, "size"_a, "T_object_marker"_a = Eigen::Matrix4d(Eigen::Matrix4d::Identity()));
  py::class_<sp::PhotometricResult>(m, "PhotometricResult")
      .def_readonly("converged", &sp::PhotometricResult::converged)
      .def_readonly("failure", &sp::PhotometricResult::failure)
      .def_property_readonly("pose", [](const sp::PhotometricResult& r) { return Eigen::Matrix4d(r.pose.matrix()); })
      .def_readonly("covariance", &sp::PhotometricResult::covariance)
      .def_readonly("psf_sd", &sp::PhotometricResult::psf_sd, "of the lens' point spread function [px]")
      .def_readonly("noise_sd", &sp::PhotometricResult::noise_sd)
      .def_readonly("iterations", &sp::PhotometricResult::iterations);
  using Refiner = OneAtATime<sp::PhotometricRefiner>;
  py::class_<Refiner>(m, "PhotometricRefiner", "Fits the pose of prints to the grey levels.")
      .def(py::init([](const py::dict& parameters) {
             return std::make_unique<Refiner>(
                 sp::loadStrict<sp::PhotometricParameters>(yaml(parameters), "photometric"));
           }),
           "parameters"_a)
      .def(
          "refine",
          [](Refiner& self, const py::array& image, const sp::CameraModel& camera,
             const std::vector<sp::PatternPlacement>& placements, const Eigen::Matrix4d& initial) {
            const cv::Mat grey = asMat(image);
            const Eigen::Isometry3d start = seater_python::pose(initial);
            return self.call(
                [&](sp::PhotometricRefiner& refiner) { return refiner.refine(grey, camera, placements, start); });
          },
          "image"_a, "camera"_a, "placements"_a, "initial"_a);
}

}  // namespace

PYBIND11_MODULE(seater_perception, m) {
  m.doc() = "Markers in camera images and the pose of the dock (docs/explanation/perception.md).";
  py::register_exception<sp::ConfigurationError>(m, "ConfigurationError", PyExc_ValueError);
  py::register_exception<sp::CalibrationError>(m, "CalibrationError", PyExc_ValueError);
  py::register_exception<sp::ImageError>(m, "ImageError", PyExc_ValueError);
  bindMarkers(m);
  bindConfiguration(m);
  bindResults(m);
  bindDetector(m);
  bindPhotometric(m);
}
