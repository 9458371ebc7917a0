// SPDX-License-Identifier: Apache-2.0
#include "ui/scene/vtk_helpers.h"

#include <vtkCellArray.h>
#include <vtkFeatureEdges.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>
#include <opencv2/imgproc.hpp>

namespace plumbline {
namespace {

vtkSmartPointer<vtkPoints> FloatPoints(const std::vector<Eigen::Vector3d>& points) {
  auto result = vtkSmartPointer<vtkPoints>::New();
  result->SetDataTypeToFloat();
  for (const Eigen::Vector3d& p : points) result->InsertNextPoint(p.data());
  return result;
}

}  // namespace

vtkSmartPointer<vtkPolyData> SurfaceOf(const TriangleMesh& mesh) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToFloat();
  for (const Eigen::Vector3f& v : mesh.vertices) points->InsertNextPoint(v.data());
  vtkNew<vtkCellArray> cells;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const vtkIdType ids[3] = {t[0], t[1], t[2]};
    cells->InsertNextCell(3, ids);
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(cells);
  if (!mesh.colors.empty()) {
    vtkNew<vtkUnsignedCharArray> colors;
    colors->SetNumberOfComponents(3);
    for (const auto& rgb : mesh.colors) colors->InsertNextTypedTuple(rgb.data());
    data->GetPointData()->SetScalars(colors);
  }
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(data);
  normals->SetFeatureAngle(40);
  normals->ConsistencyOff();  // models may be open, with triangles wound as they come
  normals->Update();
  return normals->GetOutput();
}

vtkSmartPointer<vtkPolyData> SharpEdgesOf(vtkPolyData* surface) {
  vtkNew<vtkFeatureEdges> edges;
  edges->SetInputData(surface);
  edges->SetFeatureAngle(40);
  edges->BoundaryEdgesOn();
  edges->FeatureEdgesOn();
  edges->ManifoldEdgesOff();
  edges->NonManifoldEdgesOff();
  edges->ColoringOff();
  edges->Update();
  return edges->GetOutput();
}

vtkSmartPointer<vtkPolyData> PolylineOf(const std::vector<Eigen::Vector3d>& points) {
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(FloatPoints(points));
  vtkNew<vtkCellArray> lines;
  std::vector<vtkIdType> ids(points.size());
  for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = static_cast<vtkIdType>(i);
  if (ids.size() > 1) lines->InsertNextCell(static_cast<vtkIdType>(ids.size()), ids.data());
  data->SetLines(lines);
  return data;
}

vtkSmartPointer<vtkPolyData> SegmentsOf(const std::vector<Eigen::Vector3d>& points) {
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(FloatPoints(points));
  vtkNew<vtkCellArray> lines;
  for (vtkIdType i = 0; i + 1 < static_cast<vtkIdType>(points.size()); i += 2) {
    const vtkIdType ids[2] = {i, i + 1};
    lines->InsertNextCell(2, ids);
  }
  data->SetLines(lines);
  return data;
}

vtkSmartPointer<vtkActor> ActorOf(vtkPolyData* data, ImU32 color) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  SetColor(*actor, color);
  return actor;
}

vtkSmartPointer<vtkActor> LineActorOf(vtkPolyData* data, ImU32 color, double width) {
  auto actor = ActorOf(data, color);
  actor->GetProperty()->LightingOff();
  actor->GetProperty()->SetLineWidth(static_cast<float>(width));
  actor->GetProperty()->SetPointSize(static_cast<float>(2 * width));
  return actor;
}

void SetData(vtkActor& actor, vtkPolyData* data) {
  vtkPolyDataMapper::SafeDownCast(actor.GetMapper())->SetInputData(data);
}

void ShowOwnColors(vtkActor& actor, bool show) { actor.GetMapper()->SetScalarVisibility(show); }

void SetColor(vtkActor& actor, ImU32 color) {
  const ImVec4 c = ImGui::ColorConvertU32ToFloat4(color);
  actor.GetProperty()->SetColor(c.x, c.y, c.z);
}

void SetPose(vtkActor& actor, const Eigen::Isometry3d& world_from_actor, double scale) {
  const Eigen::Matrix4d scaled = (world_from_actor * Eigen::Scaling(scale)).matrix();
  vtkNew<vtkMatrix4x4> matrix;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      matrix->SetElement(row, column, scaled(row, column));
    }
  }
  actor.SetUserMatrix(matrix);
}

vtkSmartPointer<vtkImageData> TextureImage(const cv::Mat& bgr, int max_width) {
  cv::Mat picture = bgr;
  if (picture.cols > max_width) {
    const double factor = static_cast<double>(max_width) / picture.cols;
    cv::resize(bgr, picture, {}, factor, factor, cv::INTER_AREA);
  }
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(picture.cols, picture.rows, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  cv::Mat rgb(picture.rows, picture.cols, CV_8UC3, image->GetScalarPointer());
  cv::cvtColor(picture, rgb, cv::COLOR_BGR2RGB);
  cv::flip(rgb, rgb, 0);
  return image;
}

}  // namespace plumbline
