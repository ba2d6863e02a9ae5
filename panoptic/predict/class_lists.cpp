// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Facts of the data sets; docs/networks.md names where they are documented.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "panoptic/data/nyu40.h"
#include "panoptic/predict/class_names.h"

namespace panoptic {
namespace {

constexpr std::string_view kCoco =
    "person,bicycle,car,motorcycle,airplane,bus,train,truck,boat,traffic light,fire hydrant,stop sign,parking meter,bench,"
    "bird,cat,dog,horse,sheep,cow,elephant,bear,zebra,giraffe,backpack,umbrella,handbag,tie,suitcase,frisbee,skis,snowboard,"
    "sports ball,kite,baseball bat,baseball glove,skateboard,surfboard,tennis racket,bottle,wine glass,cup,fork,knife,spoon,"
    "bowl,banana,apple,sandwich,orange,broccoli,carrot,hot dog,pizza,donut,cake,chair,couch,potted plant,bed,dining table,"
    "toilet,tv,laptop,mouse,remote,keyboard,cell phone,microwave,oven,toaster,sink,refrigerator,book,clock,vase,scissors,"
    "teddy bear,hair drier,toothbrush";
constexpr std::string_view kCocoStuff =
    "banner,blanket,bridge,cardboard,counter,curtain,door-stuff,floor-wood,flower,fruit,gravel,house,light,mirror-stuff,net,"
    "pillow,platform,playingfield,railroad,river,road,roof,sand,sea,shelf,snow,stairs,tent,towel,wall-brick,wall-stone,"
    "wall-tile,wall-wood,water-other,window-blind,window-other,tree-merged,fence-merged,ceiling-merged,sky-other-merged,"
    "cabinet-merged,table-merged,floor-other-merged,pavement-merged,mountain-merged,grass-merged,dirt-merged,paper-merged,"
    "food-other-merged,building-other-merged,rock-merged,wall-other-merged,rug-merged";
constexpr std::string_view kAde =
    "wall,building,sky,floor,tree,ceiling,road,bed,windowpane,grass,cabinet,sidewalk,person,earth,door,table,mountain,plant,"
    "curtain,chair,car,water,painting,sofa,shelf,house,sea,mirror,rug,field,armchair,seat,fence,desk,rock,wardrobe,lamp,"
    "bathtub,railing,cushion,base,box,column,signboard,chest of drawers,counter,sand,sink,skyscraper,fireplace,refrigerator,"
    "grandstand,path,stairs,runway,case,pool table,pillow,screen door,stairway,river,bridge,bookcase,blind,coffee table,"
    "toilet,flower,book,hill,bench,countertop,stove,palm,kitchen island,computer,swivel chair,boat,bar,arcade machine,hovel,"
    "bus,towel,light,truck,tower,chandelier,awning,streetlight,booth,television receiver,airplane,dirt track,apparel,pole,"
    "land,bannister,escalator,ottoman,bottle,buffet,poster,stage,van,ship,fountain,conveyer belt,canopy,washer,plaything,"
    "swimming pool,stool,barrel,basket,waterfall,tent,bag,minibike,cradle,oven,ball,food,step,tank,trade name,microwave,pot,"
    "animal,bicycle,lake,dishwasher,screen,blanket,sculpture,hood,sconce,vase,traffic light,tray,ashcan,fan,pier,crt screen,"
    "plate,monitor,bulletin board,shower,radiator,glass,clock,flag";
constexpr std::string_view kScanNet =
    "wall,floor,cabinet,bed,chair,sofa,table,door,window,bookshelf,picture,counter,desk,curtain,refrigerator,shower curtain,"
    "toilet,sink,bathtub,otherfurniture";
constexpr std::string_view kVoc =
    "aeroplane,bicycle,bird,boat,bottle,bus,car,cat,chair,cow,diningtable,dog,horse,motorbike,person,pottedplant,sheep,sofa,"
    "train,tvmonitor";
// The numbers up to 90 that are no category of COCO's detection task.
constexpr std::array<int, 10> kCocoGaps = {12, 26, 29, 30, 45, 66, 68, 69, 71, 83};

std::vector<std::string> split(std::string_view list) {
  std::vector<std::string> names;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    names.emplace_back(list.substr(begin, end - begin));
    begin = end + 1;
  }
  return names;
}

std::vector<std::string> with_background(std::vector<std::string> names) {
  names.insert(names.begin(), "background");
  return names;
}

std::vector<std::string> joined(std::vector<std::string> first, const std::vector<std::string>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

bool is_gap(int category) { return std::find(kCocoGaps.begin(), kCocoGaps.end(), category) != kCocoGaps.end(); }

// By category number, with names of their own for the gaps.
std::vector<std::string> coco_categories() {
  const std::vector<std::string> names = split(kCoco);
  std::vector<std::string> result = {"background"};
  for (int category = 1; category <= kLastCocoCategory; ++category) {
    result.push_back(is_gap(category) ? fmt::format("N/A {}", category)
                                      : names[static_cast<std::size_t>(index_of_coco_category(category))]);
  }
  return result;
}

}  // namespace

bool is_coco80(const std::vector<std::string>& classes) {
  static const std::vector<std::string> kNames = split(kCoco);
  return classes == kNames;
}

int index_of_coco_category(int category) {
  if (category < 1 || category > kLastCocoCategory || is_gap(category)) return -1;
  const auto before = std::count_if(kCocoGaps.begin(), kCocoGaps.end(), [&](int gap) { return gap < category; });
  return category - 1 - static_cast<int>(before);
}

std::vector<ClassList> class_lists_of(std::size_t count) {
  const std::vector<std::string> coco = split(kCoco);
  const std::vector<std::string> nyu(kNyu40Names.begin(), kNyu40Names.end());
  const std::vector<std::string> panoptic = joined(coco, split(kCocoStuff));
  const std::vector<ClassList> all = {{"COCO", coco},
                                      {"COCO with its background", with_background(coco)},
                                      {"COCO by category number", coco_categories()},
                                      {"COCO panoptic", panoptic},
                                      {"ADE20K", split(kAde)},
                                      {"ADE20K with a background", with_background(split(kAde))},
                                      {"NYU40", nyu},
                                      {"NYU40 with a background", with_background(nyu)},
                                      {"ScanNet", split(kScanNet)},
                                      {"PASCAL VOC with its background", with_background(split(kVoc))}};
  std::vector<ClassList> lists;
  std::copy_if(all.begin(), all.end(), std::back_inserter(lists),
               [&](const ClassList& list) { return list.classes.size() == count; });
  return lists;
}

}  // namespace panoptic
