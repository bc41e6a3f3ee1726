/** Times makePlan of the plugin beside PlanPath alone: time_plans X Y X Y ..., plans from each place to the next. */

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <costmap_2d/costmap_2d_ros.h>
#include <nav_core/base_global_planner.h>
#include <pluginlib/class_loader.hpp>
#include <ros/ros.h>
#include <social_fleet/PlanPath.h>
#include <tf2_ros/transform_listener.h>

namespace
{
constexpr int REPEATS = 7;

geometry_msgs::PoseStamped pose(double x, double y)
{
  geometry_msgs::PoseStamped result;
  result.header.frame_id = "map";
  result.pose.position.x = x;
  result.pose.position.y = y;
  result.pose.orientation.w = 1.0;
  return result;
}

double median(std::vector<double> values)
{
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

template <typename Call>
double timed(Call call)
{
  const ros::WallTime begun = ros::WallTime::now();
  if (!call())
  {
    std::fprintf(stderr, "there is no plan\n");
    std::exit(1);
  }
  return (ros::WallTime::now() - begun).toSec();
}
}  // namespace

int main(int argc, char** argv)
{
  ros::init(argc, argv, "time_plans");
  tf2_ros::Buffer buffer;
  tf2_ros::TransformListener listener(buffer);
  costmap_2d::Costmap2DROS costmap("global_costmap", buffer);
  pluginlib::ClassLoader<nav_core::BaseGlobalPlanner> loader("nav_core", "nav_core::BaseGlobalPlanner");
  boost::shared_ptr<nav_core::BaseGlobalPlanner> planner = loader.createInstance("social_fleet/SocialGlobalPlanner");
  planner->initialize("SocialGlobalPlanner", &costmap);
  ros::AsyncSpinner spinner(1);
  spinner.start();
  ros::service::waitForService("social_planner/plan_path");
  ros::ServiceClient client = ros::NodeHandle().serviceClient<social_fleet::PlanPath>("social_planner/plan_path", true);
  ros::WallDuration(3.0).sleep();  // map and costmap are filled

  std::vector<double> alone, through;
  for (int i = 1; i + 3 < argc; i += 2)
  {
    social_fleet::PlanPath service;
    service.request.start = pose(std::atof(argv[i]), std::atof(argv[i + 1]));
    service.request.goal = pose(std::atof(argv[i + 2]), std::atof(argv[i + 3]));
    service.request.inquiry = true;
    std::vector<double> one, other;
    for (int j = 0; j < REPEATS; ++j)
    {
      one.push_back(timed([&] { return client.call(service) && service.response.status == 0; }));
      std::vector<geometry_msgs::PoseStamped> plan;
      other.push_back(timed([&] { return planner->makePlan(service.request.start, service.request.goal, plan); }));
    }
    alone.push_back(median(one));
    through.push_back(median(other));
  }
  double sum_alone = 0.0, sum_through = 0.0;
  for (size_t i = 0; i < alone.size(); ++i)
  {
    sum_alone += alone[i];
    sum_through += through[i];
  }
  std::printf("%.6f %.6f\n", sum_alone / alone.size(), sum_through / through.size());
  planner.reset();
  return 0;
}
